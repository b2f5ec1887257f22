//! Text and pictures inside of HTML.

use base64::{Engine, prelude::BASE64_STANDARD};

/// `text` as text: nothing in it is taken for markup, in elements and in quoted attributes.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            _ => escaped.push(letter),
        }
    }
    escaped
}

/// A PNG file as the address of an image, so that the page is one file.
pub fn png_address(bytes: &[u8]) -> String {
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_taken_for_markup() {
        let text = r#"<b onclick="f('x')">a & b</b>"#;
        let escaped = escape(text);
        assert_eq!(escaped, "&lt;b onclick=&quot;f(&#39;x&#39;)&quot;&gt;a &amp; b&lt;/b&gt;");
        assert_eq!(escape("5 m³"), "5 m³");
    }

    #[test]
    fn pictures_are_inside() {
        assert_eq!(png_address(b"\x89PNG"), "data:image/png;base64,iVBORw==");
    }
}
