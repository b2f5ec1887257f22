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

/// `text` as text, what is between backticks as code.
pub fn prose(text: &str) -> String {
    let mut html = String::new();
    // Where there is a part after it, a part at an odd place is between two backticks.
    let parts: Vec<&str> = text.split('`').collect();
    for (place, part) in parts.iter().enumerate() {
        match (place % 2 == 1, place + 1 < parts.len()) {
            (true, true) => html += &format!("<code>{}</code>", escape(part)),
            (true, false) => html += &format!("`{}", escape(part)),
            (false, _) => html += &escape(part),
        }
    }
    html
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
    fn commands_are_code_and_a_lonely_backtick_is_itself() {
        assert_eq!(prose("run `a <b>` or `c`"), "run <code>a &lt;b&gt;</code> or <code>c</code>");
        assert_eq!(prose("a ` b"), "a ` b");
    }

    #[test]
    fn pictures_are_inside() {
        assert_eq!(png_address(b"\x89PNG"), "data:image/png;base64,iVBORw==");
    }
}
