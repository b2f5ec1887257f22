use super::{Comparison, ExpressionError};

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Number(f64),
    /// A bare word; may be a keyword.
    Word(String),
    /// A name in quotes; never a keyword.
    Quoted(String),
    Compare(Comparison),
    And,
    Or,
    Not,
    Open,
    Close,
    OpenIndex,
    CloseIndex,
    Dot,
    Comma,
    End,
}

/// Cuts `text` into tokens with their columns; the last is [`Token::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<(Token, usize)>, ExpressionError> {
    let letters: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < letters.len() {
        let at = i + 1;
        let fail = |message: String| ExpressionError { expression: text.to_owned(), column: at, message };
        let next = letters.get(i + 1).copied();
        let (token, length) = match letters[i] {
            c if c.is_whitespace() => {
                i += 1;
                continue;
            }
            '<' if next == Some('=') => (Token::Compare(Comparison::LessEqual), 2),
            '<' => (Token::Compare(Comparison::Less), 1),
            '>' if next == Some('=') => (Token::Compare(Comparison::GreaterEqual), 2),
            '>' => (Token::Compare(Comparison::Greater), 1),
            '=' if next == Some('=') => (Token::Compare(Comparison::Equal), 2),
            '=' => (Token::Compare(Comparison::Equal), 1),
            '!' if next == Some('=') => (Token::Compare(Comparison::NotEqual), 2),
            '!' => (Token::Not, 1),
            '&' if next == Some('&') => (Token::And, 2),
            '|' if next == Some('|') => (Token::Or, 2),
            '(' => (Token::Open, 1),
            ')' => (Token::Close, 1),
            '[' => (Token::OpenIndex, 1),
            ']' => (Token::CloseIndex, 1),
            ',' => (Token::Comma, 1),
            c if starts_number(c, next) => {
                let length = number_length(&letters[i..]);
                let word: String = letters[i..i + length].iter().collect();
                let value = word.parse().map_err(|_| fail(format!("{word:?} is not a number")))?;
                (Token::Number(value), length)
            }
            '.' => (Token::Dot, 1),
            quote @ ('"' | '\'') => {
                let length = letters[at..].iter().position(|&c| c == quote);
                let length = length.ok_or_else(|| fail(format!("the quote {quote} is not closed")))?;
                (Token::Quoted(letters[at..at + length].iter().collect()), length + 2)
            }
            c if is_name(c) => {
                let length = letters[i..].iter().take_while(|&&c| is_name(c)).count();
                let word: String = letters[i..i + length].iter().collect();
                let token = match word.to_ascii_lowercase().as_str() {
                    "and" => Token::And,
                    "or" => Token::Or,
                    "not" => Token::Not,
                    _ => Token::Word(word),
                };
                (token, length)
            }
            c => return Err(fail(format!("{c:?} has no meaning here"))),
        };
        tokens.push((token, at));
        i += length;
    }
    tokens.push((Token::End, letters.len() + 1));
    Ok(tokens)
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn starts_number(c: char, next: Option<char>) -> bool {
    c.is_ascii_digit()
        || (matches!(c, '-' | '+' | '.') && next.is_some_and(|c| c.is_ascii_digit()))
        || (matches!(c, '-' | '+') && next == Some('.'))
}

fn number_length(letters: &[char]) -> usize {
    let mut length = 1;
    while let Some(&c) = letters.get(length) {
        let after_exponent = matches!(letters[length - 1], 'e' | 'E');
        let goes_on = c.is_ascii_digit()
            || c == '.'
            || matches!(c, 'e' | 'E')
            || (after_exponent && matches!(c, '-' | '+'));
        if !goes_on {
            break;
        }
        length += 1;
    }
    length
}
