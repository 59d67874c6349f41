//! Evaluates the initial values of uniforms: expressions of numbers, in which the compiler has already replaced macros.
//! Whole numbers stay whole and wrap at 32 bits, as in GLSL.

/// Returns the numbers of an expression that initializes a uniform of the type `kind`: column by column for matrices,
/// and element by element for arrays. `None` for an expression that has more than numbers, constructors and arithmetic,
/// and for products of matrices and vectors.
pub fn evaluate(expression: &str, kind: &str) -> Option<Vec<f64>> {
    let kind = Kind::of_name(kind)?;
    let mut parser = Parser { text: expression.trim(), component: kind.component, open_factors: 0 };
    let term = parser.sum()?;
    if !parser.text.is_empty() {
        return None;
    }
    let numbers = term.implicitly(kind.component)?;
    if term.is_array { Some(numbers) } else { kind.constructed(numbers) }
}

/// What each number of a type is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    Bool,
    Int,
    Uint,
    Float,
}

impl Component {
    /// The component of a sum or product of numbers of two components, as in GLSL; `None` if one of them is a bool.
    fn common(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Bool, _) | (_, Self::Bool) => None,
            (Self::Float, _) | (_, Self::Float) => Some(Self::Float),
            (Self::Uint, _) | (_, Self::Uint) => Some(Self::Uint),
            (Self::Int, Self::Int) => Some(Self::Int),
        }
    }

    /// Converts a number of this component as a constructor of GLSL does. `None` for a float that does not fit into the
    /// whole numbers of `to`.
    fn converted(self, number: f64, to: Self) -> Option<f64> {
        let whole = number.trunc();
        match (self, to) {
            (_, Self::Float) => Some(number),
            (_, Self::Bool) => Some(f64::from(u8::from(number != 0.0))),
            (Self::Uint, Self::Int) => Some(f64::from(number as u32 as i32)),
            (Self::Int, Self::Uint) => Some(f64::from(number as i32 as u32)),
            (_, Self::Int) => (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&whole).then_some(whole),
            (_, Self::Uint) => (0.0..=f64::from(u32::MAX)).contains(&whole).then_some(whole),
        }
    }
}

/// A type of GLSL. A vector has one column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    component: Component,
    columns: usize,
    rows: usize,
}

impl Kind {
    /// A type of one number.
    const fn scalar(component: Component) -> Self {
        Self { component, columns: 1, rows: 1 }
    }

    /// The type that GLSL calls `name`; `None` for other types than numbers, vectors and matrices.
    fn of_name(name: &str) -> Option<Self> {
        use Component as C;
        let size = |text: &str| text.parse::<usize>().ok().filter(|size| text.len() == 1 && (2..=4).contains(size));
        if let Some(sizes) = name.strip_prefix("mat") {
            // The sizes of `mat2x3` are its columns and its rows.
            let (columns, rows) = sizes.split_once('x').unwrap_or((sizes, sizes));
            return Some(Self { component: C::Float, columns: size(columns)?, rows: size(rows)? });
        }
        let vectors = [("vec", C::Float), ("ivec", C::Int), ("uvec", C::Uint), ("bvec", C::Bool)];
        match name {
            "float" => Some(Self::scalar(C::Float)),
            "int" => Some(Self::scalar(C::Int)),
            "uint" => Some(Self::scalar(C::Uint)),
            "bool" => Some(Self::scalar(C::Bool)),
            _ => vectors.into_iter().find_map(|(prefix, component)| {
                Some(Self { component, columns: 1, rows: size(name.strip_prefix(prefix)?)? })
            }),
        }
    }

    /// The number of numbers.
    fn count(self) -> usize {
        self.columns * self.rows
    }

    /// True for a type of one number.
    fn is_scalar(self) -> bool {
        self.count() == 1
    }

    /// True for a type of several columns.
    fn is_matrix(self) -> bool {
        self.columns > 1
    }

    /// Returns the numbers that a constructor makes of converted arguments. One number alone fills a vector, or the
    /// diagonal of a matrix. `None` for any other number of numbers than the type has.
    fn constructed(self, numbers: Vec<f64>) -> Option<Vec<f64>> {
        let [number] = numbers[..] else { return (numbers.len() == self.count()).then_some(numbers) };
        let is_filled = |n: usize| !self.is_matrix() || n / self.rows == n % self.rows;
        Some((0..self.count()).map(|n| if is_filled(n) { number } else { 0.0 }).collect())
    }
}

/// An operation between two terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
}

impl Operation {
    /// Returns the result for two numbers of one component; `None` if it has no value.
    fn result(self, component: Component, a: f64, b: f64) -> Option<f64> {
        match component {
            Component::Bool => None,
            Component::Int => {
                let (a, b) = (a as i32, b as i32);
                Some(f64::from(match self {
                    Self::Add => a.wrapping_add(b),
                    Self::Subtract => a.wrapping_sub(b),
                    Self::Multiply => a.wrapping_mul(b),
                    Self::Divide if b == 0 => return None,
                    Self::Divide => a.wrapping_div(b),
                }))
            }
            Component::Uint => {
                let (a, b) = (a as u32, b as u32);
                Some(f64::from(match self {
                    Self::Add => a.wrapping_add(b),
                    Self::Subtract => a.wrapping_sub(b),
                    Self::Multiply => a.wrapping_mul(b),
                    Self::Divide => a.checked_div(b)?,
                }))
            }
            Component::Float => {
                let result = match self {
                    Self::Add => a + b,
                    Self::Subtract => a - b,
                    Self::Multiply => a * b,
                    Self::Divide => a / b,
                };
                result.is_finite().then_some(result)
            }
        }
    }

    /// Applies the operation number by number; a single number is combined with each number of the other side. `None`
    /// for sides of different types, and for products of matrices and vectors, which are not made number by number.
    fn apply(self, left: &Term, right: &Term) -> Option<Term> {
        let component = left.kind.component.common(right.kind.component)?;
        let sides = [left, right].map(|term| Kind { component, ..term.kind });
        let shape = match sides {
            _ if left.is_array || right.is_array => return None,
            [shape, other] if other.is_scalar() => shape,
            [other, shape] if other.is_scalar() => shape,
            [shape, other] if shape == other && !(shape.is_matrix() && self == Self::Multiply) => shape,
            _ => return None,
        };
        let (a, b) = (left.implicitly(component)?, right.implicitly(component)?);
        let pairs = (0..shape.count()).map(|n| Some((*a.get(n % a.len())?, *b.get(n % b.len())?)));
        let numbers = pairs.map(|pair| pair.and_then(|(a, b)| self.result(component, a, b))).collect::<Option<_>>()?;
        Some(Term { kind: shape, is_array: false, numbers })
    }
}

/// A part of an expression: its type and its numbers. An array has the type of its elements.
#[derive(Debug, Clone)]
struct Term {
    kind: Kind,
    is_array: bool,
    numbers: Vec<f64>,
}

impl Term {
    /// Makes a term of one number.
    fn scalar(component: Component, number: f64) -> Self {
        Self { kind: Kind::scalar(component), is_array: false, numbers: vec![number] }
    }

    /// Returns the numbers, converted to `to` as a constructor does; `None` if a number does not fit.
    fn explicitly(&self, to: Component) -> Option<Vec<f64>> {
        self.numbers.iter().map(|number| self.kind.component.converted(*number, to)).collect()
    }

    /// Returns the numbers, converted to `to` as GLSL does without a constructor; `None` for a conversion that it does
    /// not make, such as from floats to whole numbers.
    fn implicitly(&self, to: Component) -> Option<Vec<f64>> {
        let from = self.kind.component;
        if from == to || from.common(to) == Some(to) { self.explicitly(to) } else { None }
    }
}

/// A parser by recursive descent.
struct Parser<'a> {
    /// The part of the expression that is still to be read.
    text: &'a str,
    /// The component of the uniform, which lists in braces have.
    component: Component,
    /// The number of factors that are begun and not read to their end.
    open_factors: usize,
}

/// Greatest depth of brackets, lists and signs, which bounds the stack that an expression takes.
const MAX_OPEN_FACTORS: usize = 64;

impl Parser<'_> {
    /// Steps over `wanted` if the rest of the text begins with it, and returns whether it does.
    fn take(&mut self, wanted: &str) -> bool {
        let rest = self.text.trim_start().strip_prefix(wanted);
        self.text = rest.unwrap_or(self.text).trim_start();
        rest.is_some()
    }

    /// Reads products with plus or minus signs between them.
    fn sum(&mut self) -> Option<Term> {
        let mut left = self.product()?;
        loop {
            let operation = if self.take("+") {
                Operation::Add
            } else if self.take("-") {
                Operation::Subtract
            } else {
                return Some(left);
            };
            left = operation.apply(&left, &self.product()?)?;
        }
    }

    /// Reads factors with signs of multiplication or division between them.
    fn product(&mut self) -> Option<Term> {
        let mut left = self.factor()?;
        loop {
            let operation = if self.take("*") {
                Operation::Multiply
            } else if self.take("/") {
                Operation::Divide
            } else {
                return Some(left);
            };
            left = operation.apply(&left, &self.factor()?)?;
        }
    }

    /// Reads a factor. `None` also if it lies too deep.
    fn factor(&mut self) -> Option<Term> {
        if self.open_factors == MAX_OPEN_FACTORS {
            return None;
        }
        self.open_factors += 1;
        let factor = self.shallow_factor();
        self.open_factors -= 1;
        factor
    }

    /// Reads a sign before a factor, brackets, a list in braces, a name, or a number.
    fn shallow_factor(&mut self) -> Option<Term> {
        if self.take("-") {
            return Operation::Multiply.apply(&Term::scalar(Component::Int, -1.0), &self.factor()?);
        }
        if self.take("+") {
            return self.factor();
        }
        if self.take("(") {
            let inside = self.sum()?;
            return self.take(")").then_some(inside);
        }
        if self.take("{") {
            let elements = self.list("}")?;
            return joined(Kind::scalar(self.component), &elements);
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

    /// Reads what begins with the word `name`, behind which the parser stands: `true`, `false`, or a constructor of a
    /// type or of an array, as in `vec2(1, 2)` and `float[](1, 2)`.
    fn named(&mut self, name: &str) -> Option<Term> {
        match name {
            "true" => return Some(Term::scalar(Component::Bool, 1.0)),
            "false" => return Some(Term::scalar(Component::Bool, 0.0)),
            _ => {}
        }
        let is_array = self.take("[");
        if is_array {
            self.text = self.text.split_once(']')?.1.trim_start();
        }
        let kind = Kind::of_name(name)?;
        if !self.take("(") {
            return None;
        }
        let arguments = self.list(")")?;
        if is_array {
            return joined(kind, &arguments);
        }
        // A matrix takes over only the rows and columns that a matrix among its arguments has in common with it.
        if arguments.iter().any(|a| a.is_array || (kind.is_matrix() && a.kind.is_matrix())) {
            return None;
        }
        let parts = arguments.iter().map(|a| a.explicitly(kind.component)).collect::<Option<Vec<_>>>()?;
        Some(Term { kind, is_array: false, numbers: kind.constructed(parts.concat())? })
    }

    /// Reads expressions with commas between them, up to `end`.
    fn list(&mut self, end: &str) -> Option<Vec<Term>> {
        let mut terms = Vec::new();
        loop {
            terms.push(self.sum()?);
            if self.take(end) {
                return Some(terms);
            }
            if !self.take(",") {
                return None;
            }
        }
    }

    /// Reads a literal of GLSL.
    fn number(&mut self) -> Option<Term> {
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
        if !is_hexadecimal && number.contains(['.', 'e', 'E', 'f', 'F']) {
            let number = number.trim_end_matches(['f', 'F', 'l', 'L']);
            let value = number.parse().ok().filter(|v: &f64| v.is_finite())?;
            return Some(Term::scalar(Component::Float, value));
        }
        let unsigned = number.strip_suffix(['u', 'U']);
        let digits = unsigned.unwrap_or(number);
        // A zero before other digits makes a number octal.
        let (digits, radix) = match digits.strip_prefix('0') {
            Some(rest) if is_hexadecimal => (&rest[1..], 16),
            Some(rest) if !rest.is_empty() => (rest, 8),
            _ => (digits, 10),
        };
        let bits = u32::from_str_radix(digits, radix).ok()?;
        Some(match unsigned {
            Some(_) => Term::scalar(Component::Uint, f64::from(bits)),
            None => Term::scalar(Component::Int, f64::from(bits as i32)),
        })
    }
}

/// Makes an array of its elements, which are converted to the component of `kind`.
fn joined(kind: Kind, elements: &[Term]) -> Option<Term> {
    let parts = elements.iter().map(|element| element.implicitly(kind.component)).collect::<Option<Vec<_>>>()?;
    Some(Term { kind, is_array: true, numbers: parts.concat() })
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
    fn expressions_of_more_than_numbers_have_no_value() {
        for text in ["sin(1.0)", "N", "a ? 1.0 : 2.0", "1.0 +", "vec2(1.0", "", "1.0 2.0", "1e999"] {
            assert_eq!(evaluate(text, "float"), None, "{text}");
        }
    }

    #[test]
    fn expressions_with_too_many_brackets_or_signs_have_no_value() {
        let nested = |depth: usize| format!("{}1.0{}", "(".repeat(depth), ")".repeat(depth));
        assert_eq!(evaluate(&nested(20), "float"), Some(vec![1.0]));
        assert_eq!(evaluate(&nested(1_000_000), "float"), None);
        assert_eq!(evaluate(&format!("{}1.0", "-".repeat(1_000_000)), "float"), None);
    }

    /// GLSL drops the remainder of a division of whole numbers, reads a leading zero as octal, and wraps at 32 bits.
    #[test]
    fn whole_numbers_are_those_of_glsl() {
        let check = |text: &str, kind: &str, value: &[f64]| {
            assert_eq!(evaluate(text, kind).as_deref(), Some(value), "{kind} {text}");
        };
        check("1/2", "float", &[0.0]);
        check("1/2.0", "float", &[0.5]);
        check("7/2*2", "int", &[6.0]);
        check("-7/2", "int", &[-3.0]);
        check("ivec2(7, 9) / 2", "ivec2", &[3.0, 4.0]);
        check("vec2(1/2, 1)", "vec2", &[0.0, 1.0]);
        check("{ 1/2, 1.5 }", "float", &[0.0, 1.5]);
        check("010", "int", &[8.0]);
        check("010u + 0", "uint", &[8.0]);
        check("010.5", "float", &[10.5]);
        check("0xFFFFFFFF", "int", &[-1.0]);
        check("0xFFFFFFFFu", "uint", &[4294967295.0]);
        check("-1", "uint", &[4294967295.0]);
        check("-2147483648 / -1", "int", &[-2147483648.0]);
        check("0x7FFFFFFF + 1", "int", &[-2147483648.0]);
        check("int(2.7) + uint(1)", "uint", &[3.0]);
        check("bvec2(2, 0)", "bvec2", &[1.0, 0.0]);
        let wrong =
            [("1/0", "int"), ("1u/0u", "uint"), ("08", "int"), ("0x", "int"), ("0x100000000", "int"), ("1.5", "int")];
        for (text, kind) in wrong {
            assert_eq!(evaluate(text, kind), None, "{kind} {text}");
        }
    }

    /// Products of matrices and vectors are not made number by number; sums and factors are.
    #[test]
    fn products_of_matrices_have_no_value() {
        for (text, kind) in [
            ("mat2(1.0, 2.0, 3.0, 4.0) * mat2(2.0)", "mat2"),
            ("mat2(2.0) * vec2(1.0)", "vec2"),
            ("vec4(1.0) * mat2(2.0)", "vec4"),
            ("mat2(mat3(1.0))", "mat2"),
            ("mat2x3(mat3x2(1.0))", "mat2x3"),
        ] {
            assert_eq!(evaluate(text, kind), None, "{kind} {text}");
        }
        assert_eq!(evaluate("2 * mat2(1.0) + mat2(1.0)", "mat2"), Some(vec![3.0, 0.0, 0.0, 3.0]));
    }
}
