use super::lexer::{Token, tokens};
use super::{Column, Expression, ExpressionError, Node, Operand, Part};

/// Deeper nesting than any person writes; keeps the recursion off the end of the stack.
const MAX_DEPTH: usize = 100;

/// More comparisons than any person writes: a chain of `and` makes a tree as deep as it is long.
const MAX_TOKENS: usize = 2000;

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<(Token, usize)>,
    next: usize,
    depth: usize,
    columns: Vec<Column>,
}

pub(super) fn parse(text: &str) -> Result<Expression, ExpressionError> {
    let mut parser = Parser { text, tokens: tokens(text)?, next: 0, depth: 0, columns: Vec::new() };
    if parser.tokens.len() > MAX_TOKENS {
        return Err(parser.error(format!("more than {MAX_TOKENS} words and signs")));
    }
    let root = parser.or()?;
    if *parser.peek() != Token::End {
        return Err(parser.error("expected `and`, `or` or the end".into()));
    }
    Ok(Expression { text: text.to_owned(), root, columns: parser.columns })
}

impl Parser<'_> {
    fn peek(&self) -> &Token {
        &self.tokens[self.next].0
    }

    fn take(&mut self) -> Token {
        let token = self.tokens[self.next].0.clone();
        // The end is never stepped over.
        self.next = (self.next + 1).min(self.tokens.len() - 1);
        token
    }

    fn accept(&mut self, token: &Token) -> bool {
        let found = self.peek() == token;
        if found {
            self.take();
        }
        found
    }

    fn accept_in(&mut self) -> bool {
        let found = matches!(self.peek(), Token::Word(word) if word.eq_ignore_ascii_case("in"));
        if found {
            self.take();
        }
        found
    }

    fn error(&self, message: String) -> ExpressionError {
        let column = self.tokens[self.next].1;
        ExpressionError { expression: self.text.to_owned(), column, message }
    }

    fn expect(&mut self, token: &Token, what: &str) -> Result<(), ExpressionError> {
        if self.accept(token) { Ok(()) } else { Err(self.error(format!("expected {what}"))) }
    }

    fn or(&mut self) -> Result<Node, ExpressionError> {
        let mut node = self.and()?;
        while self.accept(&Token::Or) {
            node = Node::Or(Box::new(node), Box::new(self.and()?));
        }
        Ok(node)
    }

    fn and(&mut self) -> Result<Node, ExpressionError> {
        let mut node = self.not()?;
        while self.accept(&Token::And) {
            node = Node::And(Box::new(node), Box::new(self.not()?));
        }
        Ok(node)
    }

    fn not(&mut self) -> Result<Node, ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(format!("nested deeper than {MAX_DEPTH}")));
        }
        let node = if self.accept(&Token::Not) {
            Node::Not(Box::new(self.not()?))
        } else if self.accept(&Token::Open) {
            let node = self.or()?;
            self.expect(&Token::Close, "`)`")?;
            node
        } else {
            self.comparison()?
        };
        self.depth -= 1;
        Ok(node)
    }

    fn comparison(&mut self) -> Result<Node, ExpressionError> {
        let mut left = self.operand()?;
        if self.accept_in() {
            return self.list(left);
        }
        if *self.peek() == Token::Not {
            self.take();
            return if self.accept_in() {
                Ok(Node::Not(Box::new(self.list(left)?)))
            } else {
                Err(self.error("expected `in` after `not`".into()))
            };
        }
        let mut chain: Option<Node> = None;
        while let Token::Compare(comparison) = *self.peek() {
            self.take();
            let right = self.operand()?;
            let link = Node::Compare(left, comparison, right);
            chain = Some(match chain {
                None => link,
                Some(head) => Node::And(Box::new(head), Box::new(link)),
            });
            left = right;
        }
        chain.ok_or_else(|| self.error("expected a comparison such as `== 0`, `< 1` or `in (1, 2)`".into()))
    }

    fn list(&mut self, left: Operand) -> Result<Node, ExpressionError> {
        self.expect(&Token::Open, "`(` and a list of numbers")?;
        let mut numbers = Vec::new();
        loop {
            let Token::Number(number) = *self.peek() else {
                return Err(self.error("expected a number".into()));
            };
            self.take();
            numbers.push(number);
            if self.accept(&Token::Close) {
                return Ok(Node::In(left, numbers));
            }
            self.expect(&Token::Comma, "`,` or `)`")?;
        }
    }

    fn operand(&mut self) -> Result<Operand, ExpressionError> {
        let at = self.tokens[self.next].1;
        let name = match self.peek().clone() {
            Token::Number(number) => {
                self.take();
                return Ok(Operand::Number(number));
            }
            Token::Word(name) | Token::Quoted(name) => name,
            _ => return Err(self.error("expected an attribute or a number".into())),
        };
        self.take();
        let part = self.part()?;
        let known = self.columns.iter().position(|column| column.name == name && column.part == part);
        Ok(Operand::Column(known.unwrap_or_else(|| {
            self.columns.push(Column { name, part, at });
            self.columns.len() - 1
        })))
    }

    fn part(&mut self) -> Result<Part, ExpressionError> {
        if self.accept(&Token::Dot) {
            let index = match self.peek() {
                Token::Word(word) => ["x", "y", "z"].iter().position(|axis| axis.eq_ignore_ascii_case(word)),
                _ => None,
            };
            let index = index.ok_or_else(|| self.error("expected the component x, y or z".into()))?;
            self.take();
            return Ok(Part::Component(index));
        }
        if self.accept(&Token::OpenIndex) {
            let Token::Number(index) = *self.peek() else {
                return Err(self.error("expected the number of a component, 0 for the first".into()));
            };
            if index.fract() != 0.0 || !(0.0..1e6).contains(&index) {
                return Err(self.error("expected the number of a component, 0 for the first".into()));
            }
            self.take();
            self.expect(&Token::CloseIndex, "`]`")?;
            return Ok(Part::Component(index as usize));
        }
        Ok(Part::Whole)
    }
}
