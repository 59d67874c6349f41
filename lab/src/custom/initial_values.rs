//! Evaluates the initial values of uniforms: expressions of numbers, in which the compiler has already replaced macros.

/// Returns the numbers of an expression that initializes a uniform of the type `kind`: column by column for matrices,
/// and element by element for arrays. `None` for an expression that has more than numbers, constructors and arithmetic.
pub fn evaluate(expression: &str, kind: &str) -> Option<Vec<f64>> {
    let mut parser = Parser { text: expression.trim() };
    let numbers = parser.sum()?;
    if !parser.text.is_empty() {
        return None;
    }
    Some(constructed(kind, numbers))
}

/// Returns the numbers that the constructor of a type makes of its arguments. One number alone fills a vector, or the
/// diagonal of a matrix.
fn constructed(kind: &str, numbers: Vec<f64>) -> Vec<f64> {
    let digit = |index: usize| kind.chars().nth(index).and_then(|c| c.to_digit(10)).map(|d| d as usize);
    let [number] = numbers[..] else { return numbers };
    let vector = kind.strip_suffix(['2', '3', '4']).filter(|bare| bare.ends_with("vec"));
    match (vector, kind.strip_prefix("mat")) {
        (Some(bare), _) => vec![number; digit(bare.len()).unwrap_or(1)],
        (None, Some(_)) => {
            // The sizes in `mat3` and `mat2x3` stand behind `mat` and `x`.
            let columns = digit(3).unwrap_or(1);
            let rows = digit(5).unwrap_or(columns);
            let entry = |n: usize| if n / rows == n % rows { number } else { 0.0 };
            (0..columns * rows).map(entry).collect()
        }
        _ => numbers,
    }
}

/// A parser by recursive descent.
struct Parser<'a> {
    /// The part of the expression that is still to be read.
    text: &'a str,
}

impl Parser<'_> {
    /// Steps over `wanted` if the rest of the text begins with it, and returns whether it does.
    fn take(&mut self, wanted: &str) -> bool {
        let rest = self.text.trim_start().strip_prefix(wanted);
        self.text = rest.unwrap_or(self.text).trim_start();
        rest.is_some()
    }

    /// Reads products with plus or minus signs between them.
    fn sum(&mut self) -> Option<Vec<f64>> {
        let mut left = self.product()?;
        loop {
            let sign = if self.take("+") {
                1.0
            } else if self.take("-") {
                -1.0
            } else {
                return Some(left);
            };
            left = joined(&left, &self.product()?, |a, b| a + sign * b)?;
        }
    }

    /// Reads factors with signs of multiplication or division between them.
    fn product(&mut self) -> Option<Vec<f64>> {
        let mut left = self.factor()?;
        loop {
            if self.take("*") {
                left = joined(&left, &self.factor()?, |a, b| a * b)?;
            } else if self.take("/") {
                left = joined(&left, &self.factor()?, |a, b| a / b)?;
            } else {
                return Some(left);
            }
        }
    }

    /// Reads a factor: a sign before a factor, brackets, a list in braces, a name, or a number.
    fn factor(&mut self) -> Option<Vec<f64>> {
        if self.take("-") {
            return Some(self.factor()?.into_iter().map(|v| -v).collect());
        }
        if self.take("+") {
            return self.factor();
        }
        if self.take("(") {
            let inside = self.sum()?;
            return self.take(")").then_some(inside);
        }
        if self.take("{") {
            return self.list("}");
        }
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if self.text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            let end = self.text.find(|c| !is_name(c)).unwrap_or(self.text.len());
            let (name, rest) = self.text.split_at(end);
            self.text = rest;
            return self.named(name);
        }
        self.number()
    }

    /// Reads `true`, `false`, or a constructor.
    fn named(&mut self, name: &str) -> Option<Vec<f64>> {
        match name {
            "true" => return Some(vec![1.0]),
            "false" => return Some(vec![0.0]),
            _ => {}
        }
        let is_array = self.take("[");
        if is_array {
            self.text = self.text.split_once(']')?.1.trim_start();
        }
        let is_known =
            ["float", "int", "uint", "bool"].contains(&name) || name.contains("vec") || name.starts_with("mat");
        if !is_known || !self.take("(") {
            return None;
        }
        let inside = self.list(")")?;
        Some(if is_array { inside } else { constructed(name, inside) })
    }

    /// Reads expressions with commas between them, up to `end`, and returns all their numbers in one list.
    fn list(&mut self, end: &str) -> Option<Vec<f64>> {
        let mut all = Vec::new();
        loop {
            all.extend(self.sum()?);
            if self.take(end) {
                return Some(all);
            }
            if !self.take(",") {
                return None;
            }
        }
    }

    /// Reads a literal of GLSL.
    fn number(&mut self) -> Option<Vec<f64>> {
        let text = self.text;
        let mut end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '.').unwrap_or(text.len());
        // The exponent of a number may have a sign.
        let is_hexadecimal = text.starts_with("0x") || text.starts_with("0X");
        let has_exponent = !is_hexadecimal && text[..end].ends_with(['e', 'E']);
        if has_exponent && text[end..].starts_with(['+', '-']) {
            let rest = &text[end + 1..];
            end += 1 + rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        }
        let (number, rest) = text.split_at(end);
        self.text = rest.trim_start();
        if let Some(digits) = number.strip_prefix("0x").or(number.strip_prefix("0X")) {
            let digits = digits.trim_end_matches(['u', 'U']);
            return u32::from_str_radix(digits, 16).ok().map(|v| vec![f64::from(v)]);
        }
        let number = number.trim_end_matches(['f', 'F', 'u', 'U', 'l', 'L']);
        number.parse().ok().filter(|v: &f64| v.is_finite()).map(|v| vec![v])
    }
}

/// Applies an operation number by number; a single number is combined with each number of the other side. `None` for
/// sides of different lengths.
fn joined(left: &[f64], right: &[f64], operation: impl Fn(f64, f64) -> f64) -> Option<Vec<f64>> {
    match (left, right) {
        ([a], all) => Some(all.iter().map(|b| operation(*a, *b)).collect()),
        (all, [b]) => Some(all.iter().map(|a| operation(*a, *b)).collect()),
        _ if left.len() == right.len() => Some(left.iter().zip(right).map(|(a, b)| operation(*a, *b)).collect()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_of_numbers_have_their_values() {
        let check = |text: &str, kind: &str, value: &[f64]| {
            assert_eq!(evaluate(text, kind).as_deref(), Some(value), "{kind} {text}");
        };
        check("0.5", "float", &[0.5]);
        check("1.0f / 4", "float", &[0.25]);
        check("-(1.5e-1 + .5) * 2.0", "float", &[-1.3]);
        check("1 - 2 - 3", "int", &[-4.0]);
        check("0x1F", "int", &[31.0]);
        check("0X1E+3", "int", &[33.0]);
        check("7u", "uint", &[7.0]);
        check("true", "bool", &[1.0]);
        check("vec3(1, 2.0, 3)", "vec3", &[1.0, 2.0, 3.0]);
        check("vec3(0.5)", "vec3", &[0.5; 3]);
        check("vec4(vec2(1.0), 2, 3)", "vec4", &[1.0, 1.0, 2.0, 3.0]);
        check("vec2(1.0, 2.0) * 0.5", "vec2", &[0.5, 1.0]);
        check("mat2(1.0)", "mat2", &[1.0, 0.0, 0.0, 1.0]);
        check("mat2x3(2)", "mat2x3", &[2.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
        check("float[](1.0, 2.0)", "float", &[1.0, 2.0]);
        check("float[2](1.0, 2.0)", "float", &[1.0, 2.0]);
        check("{ 1.0, 2.0 }", "float", &[1.0, 2.0]);
        check("vec2[](vec2(1), vec2(2))", "vec2", &[1.0, 1.0, 2.0, 2.0]);
    }

    #[test]
    fn other_expressions_have_none() {
        for text in ["sin(1.0)", "N", "a ? 1.0 : 2.0", "1.0 +", "vec2(1.0", "", "1.0 2.0", "1e999"] {
            assert_eq!(evaluate(text, "float"), None, "{text}");
        }
    }
}
