//! Bytes of `data:` URIs.

use base64::{
    DecodeError, Engine,
    alphabet::{self, Alphabet},
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};

/// Bytes of a `data:` URI, or the reason why not; `None` if `uri` is no data URI.
pub fn data_uri(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let (head, body) = uri.strip_prefix("data:")?.split_once(',').unwrap_or(("", ""));
    Some(match head.ends_with(";base64") {
        true => decode(body),
        false => Err("a data: URI is not base64".into()),
    })
}

/// Either alphabet, with or without padding: exporters write all of them.
fn decode(text: &str) -> Result<Vec<u8>, String> {
    let with = |alphabet: &Alphabet| {
        let lenient = GeneralPurposeConfig::new()
            .with_decode_padding_mode(DecodePaddingMode::Indifferent)
            .with_decode_allow_trailing_bits(true);
        GeneralPurpose::new(alphabet, lenient).decode(text)
    };
    with(&alphabet::STANDARD).or_else(|_| with(&alphabet::URL_SAFE)).map_err(|error| match error {
        DecodeError::InvalidByte(..) => "a data: URI holds a letter that is not base64".into(),
        other => format!("the base64 of a data: URI is cut short ({other})"),
    })
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
        assert_eq!(decode("+/+/").unwrap(), decode("-_-_").unwrap());
    }

    #[test]
    fn other_uris_and_broken_ones_are_told_apart() {
        assert_eq!(data_uri("scene.bin"), None);
        assert!(data_uri("data:text/plain,hello").unwrap().unwrap_err().contains("not base64"));
        assert!(data_uri("data:;base64,Zm9v!").unwrap().unwrap_err().contains("a letter that is not base64"));
        assert!(data_uri("data:;base64,Zm9vY").unwrap().unwrap_err().contains("cut short"));
    }
}
