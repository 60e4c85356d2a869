//! Base64 of `data:` URIs (RFC 4648, section 4; the URL alphabet is understood too).

/// Bytes of a `data:` URI, or the reason why not; `None` if `uri` is no data URI.
pub fn data_uri(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let (head, body) = uri.strip_prefix("data:")?.split_once(',').unwrap_or(("", ""));
    Some(match head.ends_with(";base64") {
        true => decode(body),
        false => Err("a data: URI is not base64".into()),
    })
}

fn decode(text: &str) -> Result<Vec<u8>, String> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut bits = 0u32;
        for &letter in group {
            bits = bits << 6 | u32::from(value(letter).ok_or("a data: URI holds a letter that is not base64")?);
        }
        match group.len() {
            4 => bytes.extend(&bits.to_be_bytes()[1..]),
            3 => bytes.extend(&(bits << 6).to_be_bytes()[1..3]),
            2 => bytes.extend(&(bits << 12).to_be_bytes()[1..2]),
            _ => return Err("the base64 of a data: URI is cut short".into()),
        }
    }
    Ok(bytes)
}

fn value(letter: u8) -> Option<u8> {
    match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' | b'-' => Some(62),
        b'/' | b'_' => Some(63),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vectors_of_rfc_4648_decode() {
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg", "foob"), ("Zm9vYmFy", "foobar")]
        {
            let uri = format!("data:application/octet-stream;base64,{text}");
            assert_eq!(data_uri(&uri), Some(Ok(bytes.as_bytes().to_vec())), "{text}");
        }
        assert_eq!(decode("+/-_").unwrap(), [0xfb, 0xff, 0xbf]);
    }

    #[test]
    fn other_uris_and_broken_ones_are_told_apart() {
        assert_eq!(data_uri("scene.bin"), None);
        assert!(data_uri("data:text/plain,hello").unwrap().unwrap_err().contains("not base64"));
        assert!(data_uri("data:;base64,Zm9v!").unwrap().unwrap_err().contains("a letter that is not base64"));
        assert!(data_uri("data:;base64,Zm9vY").unwrap().unwrap_err().contains("cut short"));
    }
}
