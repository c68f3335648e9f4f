//! URIs as glTF uses them: embedded `data:` or a percent-encoded relative path; everything else is refused.

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};

use crate::excerpt::excerpt;
use crate::scene::error::SceneFault;

/// Where a URI leads.
#[derive(Debug, PartialEq, Eq)]
pub enum Target {
    /// The bytes were in the URI itself.
    Embedded(Vec<u8>),
    /// A path relative to the scene's folder, decoded.
    Relative(String),
}

/// Base64 as exporters write it: with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Understands a URI.
///
/// # Errors
/// For damaged data URIs, other schemes (`http:`, `file:`) and paths that are not UTF-8.
pub fn parse(uri: &str) -> Result<Target, SceneFault> {
    if let Some(data) = strip_scheme(uri, "data:") {
        return decode_data(data).map(Target::Embedded).map_err(|problem| fault(uri, problem));
    }
    if let Some(scheme) = scheme_of(uri) {
        return Err(fault(uri, format!("has the scheme `{scheme}:`, which is not read")));
    }
    let bytes = percent_decode(uri);
    let path = String::from_utf8(bytes).map_err(|_| fault(uri, "does not decode to UTF-8".into()))?;
    Ok(Target::Relative(path))
}

fn fault(uri: &str, problem: String) -> SceneFault {
    let remedy = "put the file beside the scene, or embed it as a data: URI or in a .glb";
    SceneFault::Uri { uri: excerpt(uri), problem, remedy }
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme).then(|| &uri[scheme.len()..])
}

/// RFC 3986, section 3.1: a letter, then letters, digits, `+`, `-`, `.`, up to the first colon.
fn scheme_of(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut characters = scheme.chars();
    let starts = characters.next().is_some_and(|c| c.is_ascii_alphabetic());
    (starts && characters.all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))).then_some(scheme)
}

/// RFC 2397: `[mediatype][;base64],data`.
fn decode_data(data: &str) -> Result<Vec<u8>, String> {
    let (head, body) = data.split_once(',').ok_or("is a data: URI without a comma")?;
    if head.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(body).map_err(|e| format!("is damaged base64 ({e})"))
    } else {
        Ok(percent_decode(body))
    }
}

/// Decodes `%41`; a percent sign without two hexadecimal digits stands for itself.
fn percent_decode(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = text.get(at + 1..at + 3).filter(|hex| hex.bytes().all(|b| b.is_ascii_hexdigit()));
        match code.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) if bytes[at] == b'%' => {
                out.push(byte);
                at += 3;
            }
            _ => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_are_decoded() {
        for uri in
            ["data:application/octet-stream;base64,AAEC", "data:;base64,AAEC", "DATA:;BASE64,AAEC", "data:,%00%01%02"]
        {
            assert_eq!(parse(uri).ok(), Some(Target::Embedded(vec![0, 1, 2])), "{uri}");
        }
        assert_eq!(parse("data:;base64,AAE").ok(), Some(Target::Embedded(vec![0, 1])));
        assert!(parse("data:;base64,A*EC").is_err());
        assert!(parse("data:nothing").is_err());
    }

    #[test]
    fn relative_paths_are_percent_decoded_and_schemes_refused() {
        assert_eq!(parse("a%20b/%C3%A4.bin").ok(), Some(Target::Relative("a b/ä.bin".into())));
        assert_eq!(parse("100%.bin").ok(), Some(Target::Relative("100%.bin".into())));
        for bad in ["http://localhost/x", "file:///dev/null", "%FF%FE.bin", "FTP:x"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
