//! The binary container of glTF: a header, a JSON chunk, perhaps a binary chunk.
//!
//! Source: glTF 2.0 Specification, section 4, "GLB File Format Specification".

/// JSON text and binary chunk of a file; the reason in words where it is none.
pub fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| bytes.get(at..at + 4).map(|w| u32::from_le_bytes(w.try_into().expect("four bytes")));
    let cut = || format!("the header of 12 bytes is cut short: the file holds {} bytes; copy it again", bytes.len());
    if !bytes.starts_with(b"glTF") {
        return Err("it does not start with the letters glTF, so it is no binary glTF file".into());
    }
    let (version, length) = (word(4).ok_or_else(cut)?, word(8).ok_or_else(cut)? as usize);
    if version != 2 {
        return Err(format!("it is binary glTF version {version}, expected 2; export it as glTF 2.0"));
    }
    if length > bytes.len() {
        return Err(format!(
            "its header says {length} bytes, the file holds {}; it was cut short, copy it again",
            bytes.len()
        ));
    }
    let (mut rest, mut json, mut binary) = (bytes.get(12..length).unwrap_or_default(), None, None);
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let (size, kind) = (u32::from_le_bytes(head[..4].try_into().expect("four bytes")) as usize, &head[4..]);
        let Some((chunk, next)) = after.split_at_checked(size) else {
            return Err(format!(
                "a chunk of {size} bytes is announced where {} are left; export it again",
                after.len()
            ));
        };
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {} // later versions may add chunks, which readers skip
        }
        // Chunks are padded to four bytes, and their size should count the padding; some writers forget it.
        rest = if next.len() >= 8 { next } else { &[] };
    }
    json.map(|json| (json, binary)).ok_or_else(|| "it has no JSON chunk; export it again".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(length: u32, chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = [b"glTF".as_slice(), &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
        for (kind, chunk) in chunks {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(*kind);
            bytes.extend(*chunk);
        }
        bytes
    }

    #[test]
    fn json_and_binary_chunks_are_found_and_unknown_ones_skipped() {
        let bytes = file(12 + 8 + 4 + 8 + 4 + 8 + 4, &[(b"JSON", b"{}  "), (b"what", b"1234"), (b"BIN\0", b"abcd")]);
        assert_eq!(split(&bytes), Ok((&b"{}  "[..], Some(&b"abcd"[..]))));
    }

    #[test]
    fn broken_containers_are_refused_in_words() {
        let refused = |bytes: &[u8]| split(bytes).unwrap_err();
        assert!(refused(b"PK\x03\x04").contains("does not start with the letters glTF"));
        assert!(refused(b"glTF\x02\0\0\0").contains("cut short"));
        assert!(refused(&[b"glTF".as_slice(), &[1, 0, 0, 0, 12, 0, 0, 0]].concat()).contains("version 1, expected 2"));
        assert!(refused(&file(99, &[])).contains("its header says 99 bytes, the file holds 12"));
        assert!(refused(&file(12, &[])).contains("no JSON chunk"));
        let mut long = file(24, &[(b"JSON", b"{}  ")]);
        long[12] = 200;
        assert!(refused(&long).contains("a chunk of 200 bytes is announced where 4 are left"));
    }
}
