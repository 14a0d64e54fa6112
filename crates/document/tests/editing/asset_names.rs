//! Text form of an asset's hash.

use document::{AssetHash, InvalidAssetHash};

/// Rules: DOC-5
#[test]
fn a_name_reads_as_it_is_written() {
    let bytes = std::array::from_fn(|i| (i * 8 + 7) as u8);
    let hash = AssetHash(bytes);
    let text = hash.to_string();
    assert_eq!(text.len(), "sha256:".len() + 64);
    assert!(text.starts_with("sha256:070f171f") && text.ends_with("eff7ff"));
    assert_eq!((text.parse(), format!("{hash:?}"), hash.hex()), (Ok(hash), text.clone(), text[7..].into()));
}

/// Rules: DOC-5
#[test]
fn anything_else_is_refused() {
    let digits = "0123456789abcdef".repeat(4);
    assert!(format!("sha256:{digits}").parse::<AssetHash>().is_ok());
    let (short, upper) = (&digits[1..], digits.to_uppercase());
    let two_byte = format!("é{}", &digits[2..]);
    for text in [
        String::new(),
        digits.clone(),
        format!("sha256:{short}"),
        format!("sha256:{digits}0"),
        format!("sha256:{upper}"),
        format!("sha256:{short}g"),
        format!("sha256:{two_byte}"),
        format!("sha256: {short}"),
        format!("SHA256:{digits}"),
        format!("sha256:+{short}"),
    ] {
        assert_eq!(text.parse::<AssetHash>(), Err(InvalidAssetHash), "{text}");
    }
}
