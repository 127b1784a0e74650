//! Expressions of numbers and the clock: read as POV-Ray reads them, and reckoned
//! nearly as it does.

use std::collections::HashMap;

use super::lex::{Kind, Token};

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A constant.
    Number(f64),
    /// The clock.
    Clock,
    /// The number of the frame.
    Frame,
    /// A function, or an operator.
    Call(&'static str, Vec<Expression>),
}

/// Functions of numbers, and how many they take at least and at most.
const FUNCTIONS: &[(&str, usize, usize)] = &[
    ("abs", 1, 1),
    ("ceil", 1, 1),
    ("cos", 1, 1),
    ("div", 2, 2),
    ("exp", 1, 1),
    ("floor", 1, 1),
    ("int", 1, 1),
    ("max", 2, 9),
    ("min", 2, 9),
    ("mod", 2, 2),
    ("pow", 2, 2),
    ("radians", 1, 1),
    ("select", 3, 4),
    ("sin", 1, 1),
    ("sqrt", 1, 1),
];

impl Expression {
    /// Its value, about.
    pub fn value(&self, clock: f64, frame: f64) -> f64 {
        let (name, list) = match self {
            Self::Number(number) => return *number,
            Self::Clock => return clock,
            Self::Frame => return frame,
            Self::Call(name, list) => (*name, list),
        };
        let values: Vec<f64> = list.iter().map(|e| e.value(clock, frame)).collect();
        let at = |k: usize| values.get(k).copied().unwrap_or(f64::NAN);
        let (a, b) = (at(0), at(1));
        let truth = |is: bool| f64::from(u8::from(is));
        match name {
            "abs" => a.abs(),
            "ceil" => a.ceil(),
            "cos" => a.cos(),
            "div" => (a / b).trunc(),
            "exp" => a.exp(),
            "floor" => a.floor(),
            "int" => a.trunc(),
            "max" => values.iter().copied().fold(a, f64::max),
            "min" => values.iter().copied().fold(a, f64::min),
            "mod" => a % b,
            "pow" => a.powf(b),
            "radians" => a.to_radians(),
            "select" if a < 0.0 => b,
            "select" if values.len() == 3 || a == 0.0 => at(2),
            "select" => at(3),
            "sin" => a.sin(),
            "sqrt" => a.sqrt(),
            "+" => a + b,
            "-" => a - b,
            "*" => a * b,
            "/" => a / b,
            "<" => truth(a < b),
            ">" => truth(a > b),
            "<=" => truth(a <= b),
            ">=" => truth(a >= b),
            "=" => truth(a == b),
            "&" => truth(a != 0.0 && b != 0.0),
            "|" => truth(a != 0.0 || b != 0.0),
            _ => f64::NAN,
        }
    }
}

/// What names stand for.
pub type Names<'a> = HashMap<&'a str, Expression>;

/// Reads expressions of numbers and the clock.
struct Reader<'t, 'a> {
    list: &'t [Token<'a>],
    names: &'t Names<'a>,
    at: usize,
}

impl Reader<'_, '_> {
    fn mark(&mut self, marks: &[&'static str]) -> Option<&'static str> {
        let token = self.list.get(self.at)?;
        let found = marks.iter().find(|mark| token.is_mark(mark))?;
        self.at += 1;
        // Two marks may be one sign.
        let follows = self
            .list
            .get(self.at)
            .filter(|next| next.start == token.end);
        match (*found, follows) {
            ("<", Some(next)) if next.is_mark("=") => {
                self.at += 1;
                Some("<=")
            }
            (">", Some(next)) if next.is_mark("=") => {
                self.at += 1;
                Some(">=")
            }
            _ => Some(found),
        }
    }

    fn chain(
        &mut self,
        marks: &[&'static str],
        part: fn(&mut Self) -> Option<Expression>,
    ) -> Option<Expression> {
        let mut sum = part(self)?;
        while let Some(mark) = self.mark(marks) {
            sum = Expression::Call(mark, vec![sum, part(self)?]);
        }
        Some(sum)
    }

    fn whole(&mut self) -> Option<Expression> {
        self.chain(&["&", "|"], Self::compared)
    }

    fn compared(&mut self) -> Option<Expression> {
        self.chain(&["<", ">", "="], Self::sum)
    }

    fn sum(&mut self) -> Option<Expression> {
        self.chain(&["+", "-"], Self::product)
    }

    fn product(&mut self) -> Option<Expression> {
        self.chain(&["*", "/"], Self::factor)
    }

    fn factor(&mut self) -> Option<Expression> {
        if self.mark(&["-"]).is_some() {
            let zero = Expression::Number(0.0);
            return Some(Expression::Call("-", vec![zero, self.factor()?]));
        }
        if self.mark(&["("]).is_some() {
            let inner = self.whole()?;
            self.mark(&[")"])?;
            return Some(inner);
        }
        let token = self.list.get(self.at)?;
        self.at += 1;
        match (token.kind, token.text) {
            (Kind::Number, text) => text.parse().ok().map(Expression::Number),
            (Kind::Word, "clock") => Some(Expression::Clock),
            (Kind::Word, "frame_number") => Some(Expression::Frame),
            (Kind::Word, "pi") => Some(Expression::Number(std::f64::consts::PI)),
            (Kind::Word, name) if self.names.contains_key(name) => self.names.get(name).cloned(),
            (Kind::Word, name) => {
                let (name, least, most) = FUNCTIONS.iter().find(|(own, ..)| *own == name)?;
                self.mark(&["("])?;
                let mut list = vec![self.whole()?];
                while self.mark(&[","]).is_some() {
                    list.push(self.whole()?);
                }
                self.mark(&[")"])?;
                let count = *least..=*most;
                count
                    .contains(&list.len())
                    .then_some(Expression::Call(name, list))
            }
            _ => None,
        }
    }
}

/// All of these tokens as one expression, if they are one.
pub fn read<'a>(list: &[Token<'a>], names: &Names<'a>) -> Option<Expression> {
    let mut reader = Reader { list, names, at: 0 };
    let found = reader.whole()?;
    (reader.at == list.len()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unedited::lex::lex;

    #[test]
    fn values() {
        for (text, value) in [
            ("1 + 2 * 3 - 4 / 8", 6.5),
            ("-(clock - 2) * 2", 3.0),
            ("floor(frame_number / 3) + mod(frame_number, 3)", 3.0),
            ("(clock >= .5) & (frame_number < 7) | 0", 0.0),
            ("min(3, clock, 7) + max(1, 2)", 2.5),
            ("select(clock - 1, 1, 2, 3) + select(0, 1, 2)", 3.0),
            ("int(-1.5) + div(7, 2) + ceil(.1) + abs(-1)", 4.0),
            ("(clock = 0.5) + (clock <= 0.25)", 1.0),
        ] {
            let found = read(&lex(text.as_bytes()).tokens, &Names::new());
            let found = found.map(|expression| expression.value(0.5, 7.0));
            assert_eq!(found, Some(value), "{text}");
        }
    }

    #[test]
    fn what_is_none() {
        for text in [
            "",
            "clock *",
            "B",
            "(clock",
            "clock)",
            "<clock, 0>",
            "f(clock)",
            "mod(1)",
            "floor(1, 2)",
            "clock, 1",
            "clock ? 1 : 0",
            "\"clock\"",
            "clock.x",
        ] {
            let found = read(&lex(text.as_bytes()).tokens, &Names::new());
            assert_eq!(found, None, "{text}");
        }
    }
}
