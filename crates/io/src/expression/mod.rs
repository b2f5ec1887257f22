//! Selections such as `type == 0 and z < 2.5`.
//!
//! ```text
//! expression = and { ("or" | "||") and }
//! and        = not { ("and" | "&&") not }
//! not        = ("not" | "!") not | "(" expression ")" | comparison
//! comparison = operand (("<" | "<=" | ">" | ">=" | "==" | "=" | "!=") operand)+
//!            | operand ["not"] "in" "(" number { "," number } ")"
//! operand    = number | attribute [ "." component | "[" index "]" ]
//! ```
//!
//! An attribute is an array of the file; a vector stands for its magnitude, `velocity.x` or `velocity[0]` for a component.
//! `x`, `y`, `z` are the coordinates in the file's space and `id` the identity, unless the file has arrays of these names.
//! Names with other characters than letters, digits and underscores are written in quotes: `"p / rho" > 1`. Comparisons chain:
//! `0 < z < 1`.

mod lexer;
mod parser;

use std::fmt;

/// Why an expression is refused: where, what was expected, what there is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpressionError {
    /// The expression as given.
    pub expression: String,
    /// Where it goes wrong: 1 for the first character.
    pub column: usize,
    /// Expected, found, what there is.
    pub message: String,
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "in the selection {:?}, column {}: {}", self.expression, self.column, self.message)
    }
}

impl std::error::Error for ExpressionError {}

/// A quantity that an expression reads for every particle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    pub name: String,
    pub part: Part,
    /// Where it stands in the expression, for messages: 1 for the first character.
    pub at: usize,
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.part {
            Part::Whole => write!(f, "{}", self.name),
            Part::Component(index) => write!(f, "{}[{index}]", self.name),
        }
    }
}

/// Which number of a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// The magnitude; the value itself of a scalar.
    Whole,
    Component(usize),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operand {
    Number(f64),
    /// Index in [`Expression::columns`].
    Column(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node {
    Or(Box<Node>, Box<Node>),
    And(Box<Node>, Box<Node>),
    Not(Box<Node>),
    Compare(Operand, Comparison, Operand),
    In(Operand, Vec<f64>),
}

/// A selection, parsed but not yet tied to a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    root: Node,
    columns: Vec<Column>,
}

impl Expression {
    /// Parses `text` by the grammar above.
    ///
    /// # Errors
    /// [`ExpressionError`] points at the column where the text departs from the grammar.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        parser::parse(text)
    }

    /// The text it was parsed from.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The quantities it reads, in the order in which [`Self::matches`] asks for them.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// An error at `column`'s place in the text.
    pub(crate) fn error_at(&self, column: &Column, message: String) -> ExpressionError {
        ExpressionError { expression: self.text.clone(), column: column.at, message }
    }

    /// Whether a particle is selected; `value` gives the number of column `i`. A comparison with NaN is false, except `!=`.
    pub(crate) fn matches(&self, value: &impl Fn(usize) -> f64) -> bool {
        self.root.matches(value)
    }
}

impl Node {
    fn matches(&self, value: &impl Fn(usize) -> f64) -> bool {
        let of = |operand: &Operand| match operand {
            Operand::Number(number) => *number,
            Operand::Column(column) => value(*column),
        };
        match self {
            Self::Or(a, b) => a.matches(value) || b.matches(value),
            Self::And(a, b) => a.matches(value) && b.matches(value),
            Self::Not(a) => !a.matches(value),
            Self::Compare(a, comparison, b) => {
                let (a, b) = (of(a), of(b));
                match comparison {
                    Comparison::Less => a < b,
                    Comparison::LessEqual => a <= b,
                    Comparison::Greater => a > b,
                    Comparison::GreaterEqual => a >= b,
                    Comparison::Equal => a == b,
                    Comparison::NotEqual => a != b,
                }
            }
            Self::In(a, numbers) => numbers.contains(&of(a)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evaluates with `type` = 2, `z` = 0.5, `velocity.y` = -3, `velocity` = 5, everything else NaN.
    fn eval(text: &str) -> bool {
        let expression = Expression::parse(text).expect(text);
        expression.matches(&|i| {
            let column = &expression.columns()[i];
            match (column.name.as_str(), column.part) {
                ("type", Part::Whole) => 2.0,
                ("z", Part::Whole) => 0.5,
                ("velocity", Part::Component(1)) => -3.0,
                ("velocity", Part::Whole) => 5.0,
                _ => f64::NAN,
            }
        })
    }

    #[test]
    fn the_grammar_means_what_it_says() {
        for yes in [
            "type == 2",
            "type=2",
            "type in (1, 2)",
            "type not in (0, 1)",
            "not type == 1",
            "!(type == 1) && z < 1",
            "0 < z < 1",
            "velocity.y < 0",
            "velocity[1] <= -3",
            "velocity >= 5",
            "type == 1 or z == 5e-1",
            "type == 2 or type == 1 and z > 7",
            "\"velocity\" == 5",
            "2 == type",
            "other != 1",
            "TYPE == 2 or NOT z > 1",
        ] {
            assert!(eval(yes), "{yes}");
        }
        for no in [
            "type != 2",
            "type in (1, 3)",
            "0 < z < 0.25",
            "(type == 2 or type == 1) and z > 7",
            "other == 1",
            "other < 1",
            "not type == 2",
        ] {
            assert!(!eval(no), "{no}");
        }
    }

    #[test]
    fn errors_point_at_the_place() {
        for (text, column) in [
            ("", 1),
            ("type ==", 8),
            ("type == 0 and", 14),
            ("type @ 1", 6),
            ("(type == 1", 11),
            ("type == 1)", 10),
            ("type in 1", 9),
            ("type in (1 2)", 12),
            ("velocity.w == 1", 10),
            ("velocity[x] == 1", 10),
            ("\"abc == 1", 1),
            ("type", 5),
            ("1e == 2", 1),
        ] {
            let error = Expression::parse(text).expect_err(text);
            assert_eq!(error.column, column, "{error}");
        }
    }

    #[test]
    fn deep_nesting_is_refused_not_overflowed() {
        for bracket in ["(", "not ", "!"] {
            assert!(Expression::parse(&bracket.repeat(100_000)).is_err());
        }
        assert!(Expression::parse(&format!("{}z<1{}", "(".repeat(50), ")".repeat(50))).is_ok());
        assert!(Expression::parse(&"z<1 and ".repeat(100_000)).is_err());
    }
}
