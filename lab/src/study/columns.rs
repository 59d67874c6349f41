//! The columns of a study's rows. A row declares each column once, with `columns!`: its name in records, its meaning, and how
//! tables show it. A column is either a figure, which is equal to the bit on every machine, or a time, which is kept apart by
//! device. Tables, CSV files and the comparison of shards follow from the declaration.

use ssct_truth::metrics::HitAgreement;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A value of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Datum {
    /// No value: null in JSON, empty in CSV, a dash in tables.
    Nothing,
    /// Words.
    Text(String),
    /// A whole number.
    Count(u64),
    /// A number.
    Number(f64),
}

/// A type whose values can be written in a column.
pub trait AsDatum {
    /// Returns the value as a datum.
    fn datum(&self) -> Datum;
}

/// Implements [`AsDatum`] for each listed type; behind the colon stands a closure that makes a datum of a reference to
/// a value.
macro_rules! as_datum {
    ($($T:ty: $make:expr),* $(,)?) => {
        $( impl AsDatum for $T {
            fn datum(&self) -> Datum {
                let make: fn(&Self) -> Datum = $make;
                make(self)
            }
        } )*
    };
}

as_datum! {
    f64: |v| Datum::Number(*v),
    // Goes by the shortest decimal text, so that 0.1 as an f32 becomes 0.1 as an f64, and not 0.100000001….
    f32: |v| Datum::Number(v.to_string().parse().unwrap_or(f64::NAN)),
    u32: |n| Datum::Count((*n).into()),
    u64: |n| Datum::Count(*n),
    usize: |n| Datum::Count(*n as u64),
    bool: |v| Datum::Text(if *v { "yes" } else { "no" }.to_owned()),
    String: |text| Datum::Text(text.clone()),
}

impl<T: AsDatum> AsDatum for Option<T> {
    fn datum(&self) -> Datum {
        self.as_ref().map_or(Datum::Nothing, AsDatum::datum)
    }
}

/// Computes a column's value of a row, each time it is called.
type Value<R> = Rc<dyn Fn(&R) -> Datum>;

/// A column of rows of one type.
pub struct Column<R> {
    /// The name in CSV files, which the field of the record has, too. A column without a name is shown in tables alone.
    pub name: String,
    /// The header in tables. A column without a header is written to CSV files alone.
    pub title: String,
    /// Meaning of the column.
    pub about: &'static str,
    /// How tables show the value.
    form: Form,
    value: Value<R>,
}

/// How tables show a number.
#[derive(Debug, Clone, Copy)]
struct Form {
    /// Digits behind the point.
    digits: usize,
    /// Whether the number is a share, which is shown in percent.
    is_share: bool,
}

impl Form {
    /// No digits behind the point, and no share.
    const PLAIN: Self = Self { digits: 0, is_share: false };

    /// Returns the text of a datum in a table.
    fn text(self, datum: &Datum) -> String {
        match datum {
            Datum::Nothing => "-".to_owned(),
            Datum::Text(text) => text.clone(),
            Datum::Count(n) => n.to_string(),
            Datum::Number(v) if self.is_share => format!("{:.*}", self.digits, 100.0 * v),
            Datum::Number(v) => format!("{v:.*}", self.digits),
        }
    }
}

impl<R> Clone for Column<R> {
    fn clone(&self) -> Self {
        let (name, title, value) = (self.name.clone(), self.title.clone(), Rc::clone(&self.value));
        Self { name, title, value, ..*self }
    }
}

impl<R: 'static> Column<R> {
    /// A column for tables alone, whose value `value` computes from a row; numbers are shown with `digits` digits
    /// behind the point.
    pub fn derived<T: AsDatum>(title: &str, digits: usize, value: impl Fn(&R) -> T + 'static) -> Self {
        let form = Form { digits, is_share: false };
        let value: Value<R> = Rc::new(move |row| value(row).datum());
        Self { name: String::new(), title: title.to_owned(), about: "", form, value }
    }

    /// A column for CSV files alone, whose value `value` computes from a row.
    pub fn named<T: AsDatum>(name: &str, value: impl Fn(&R) -> T + 'static) -> Self {
        let value: Value<R> = Rc::new(move |row| value(row).datum());
        Self { name: name.to_owned(), title: String::new(), about: "", form: Form::PLAIN, value }
    }

    /// Returns the value as a table shows it.
    pub fn shown(&self, row: &R) -> String {
        self.form.text(&(self.value)(row))
    }

    /// Returns the value, if it is a [`Datum::Number`].
    pub fn number(&self, row: &R) -> Option<f64> {
        if let Datum::Number(v) = (self.value)(row) { Some(v) } else { None }
    }

    /// Returns the text of a number that was computed from values of the column, such as their mean, as a table shows
    /// it.
    pub fn shown_number(&self, number: Option<f64>) -> String {
        self.form.text(&number.datum())
    }

    /// Returns the value as a CSV file has it; a number has all its digits.
    pub fn written(&self, row: &R) -> String {
        match (self.value)(row) {
            Datum::Nothing => String::new(),
            Datum::Text(text) => text,
            Datum::Count(n) => n.to_string(),
            Datum::Number(v) => v.to_string(),
        }
    }

    /// Returns this column for rows of type `O`, which have a part of type `R`; `get` returns the part of a row.
    fn within<O: 'static>(&self, get: fn(&O) -> &R) -> Column<O> {
        let Self { name, title, about, form, value } = self.clone();
        Column { name, title, about, form, value: Rc::new(move |row| value(get(row))) }
    }

    /// Returns this column for a part that may be missing.
    fn in_optional(&self) -> Column<Option<R>> {
        let Self { name, title, about, form, value } = self.clone();
        let optional_value = move |part: &Option<R>| part.as_ref().map_or(Datum::Nothing, &*value);
        Column { name, title, about, form, value: Rc::new(optional_value) }
    }
}

/// Computes a list of the items of a row, each time it is called. An item is a list with the text of each of its
/// columns.
type Items<R> = Rc<dyn Fn(&R) -> Vec<Vec<String>>>;

/// The items of a list that each row has, such as its frames, which get a CSV file of their own.
pub struct Series<R> {
    /// The field of the record that holds the list.
    pub name: &'static str,
    /// The names of the items' columns.
    pub names: Vec<String>,
    /// The values of the items of a row, as a CSV file has them.
    pub items: Items<R>,
}

/// Everything that is declared about rows of one type.
pub struct ColumnSet<R> {
    /// The columns, in order.
    pub columns: Vec<Column<R>>,
    /// The list of items that each row has, if any.
    pub series: Option<Series<R>>,
    /// The names of the fields that are times, at whatever depth of a record.
    pub times: BTreeSet<&'static str>,
    /// The least and the greatest value of each field that is a number, at whatever depth of a record.
    pub ranges: BTreeMap<&'static str, [f64; 2]>,
}

impl<R> Default for ColumnSet<R> {
    fn default() -> Self {
        Self { columns: Vec::new(), series: None, times: BTreeSet::new(), ranges: BTreeMap::new() }
    }
}

/// A type whose fields are columns.
pub trait Columns: Sized + 'static {
    /// Returns the columns of the type, with their times and ranges.
    fn columns() -> ColumnSet<Self>;
}

/// The declaration of a field with one value, from which a column is made.
pub struct Scalar {
    title: &'static str,
    form: Form,
    is_time: bool,
    /// Least and greatest number that the field can have.
    range: [f64; 2],
}

/// The range of a column's numbers, unless the column sets another range.
const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];

/// Declares a figure, which is equal to the bit on every machine. `title` is its header in tables; an empty title
/// leaves it out of tables.
pub const fn figure(title: &'static str) -> Scalar {
    Scalar { title, form: Form { digits: 4, is_share: false }, is_time: false, range: NOT_NEGATIVE }
}

/// Declares a time, or a value that follows from times, which is kept apart by device. `title` is its header in tables;
/// an empty title leaves it out of tables.
pub const fn time(title: &'static str) -> Scalar {
    Scalar { title, form: Form { digits: 3, is_share: false }, is_time: true, range: NOT_NEGATIVE }
}

impl Scalar {
    /// Sets the number of digits that tables show behind the point.
    pub const fn digits(mut self, digits: usize) -> Self {
        self.form.digits = digits;
        self
    }

    /// Marks a share, which lies between 0 and 1, and which tables show in percent.
    pub const fn share(mut self) -> Self {
        self.form.is_share = true;
        self.range = [0.0, 1.0];
        self
    }

    /// Allows the number to be negative.
    pub const fn signed(mut self) -> Self {
        self.range = [f64::NEG_INFINITY, f64::INFINITY];
        self
    }

    /// Adds the column of the field to the columns of its row. The pair has the field's name and its doc comment;
    /// `get` returns the field of a row.
    pub fn add<R: 'static, T: AsDatum + 'static>(
        self,
        (name, about): (&'static str, &'static str),
        get: fn(&R) -> &T,
        row_columns: &mut ColumnSet<R>,
    ) {
        if self.is_time {
            row_columns.times.insert(name);
        }
        row_columns.ranges.insert(name, self.range);
        let (name, title) = (name.to_owned(), self.title.to_owned());
        let form = self.form;
        let value: Value<R> = Rc::new(move |row| get(row).datum());
        row_columns.columns.push(Column { name, title, about, form, value });
    }
}

/// The declaration of a field whose type has columns of its own.
pub struct Part {
    /// The title of a field that is nested in records; `None` for a field that is flattened.
    prefix: Option<&'static str>,
}

/// Declares a field that is flattened: in records its own fields stand beside the row's other fields.
pub const fn part() -> Part {
    Part { prefix: None }
}

/// Declares a field that is an object of its own in records. Tables put `title` before the headers of its columns; an
/// empty title leaves these columns out of tables.
pub const fn nested(title: &'static str) -> Part {
    Part { prefix: Some(title) }
}

impl Part {
    /// Adds the columns of the field to the columns of its row. The pair has the field's name and its doc comment,
    /// which is not used; `get` returns the field of a row.
    pub fn add<R: 'static, T: Columns>(
        self,
        (name, _): (&'static str, &'static str),
        get: fn(&R) -> &T,
        row_columns: &mut ColumnSet<R>,
    ) {
        let part = T::columns();
        row_columns.times.extend(part.times);
        row_columns.ranges.extend(part.ranges);
        row_columns.columns.extend(part.columns.iter().map(|column| {
            let mut column = column.within(get);
            if let Some(title) = self.prefix {
                column.name = format!("{name}.{}", column.name);
                let is_shown = !(title.is_empty() || column.title.is_empty());
                column.title = if is_shown { format!("{title} {}", column.title) } else { String::new() };
            }
            column
        }));
    }
}

/// The declaration of a field that makes no column, and whose whole value counts as a time.
pub struct Times;

/// Declares a field, of any type, that makes no column, and whose whole value counts as a time.
pub const fn times() -> Times {
    Times
}

impl Times {
    /// Adds the field's name, which comes first in the pair, to the times of its row.
    pub fn add<R: 'static, T: 'static>(
        self,
        (name, _): (&'static str, &'static str),
        _get: fn(&R) -> &T,
        row_columns: &mut ColumnSet<R>,
    ) {
        row_columns.times.insert(name);
    }
}

/// The declaration of a field that is a list of items.
pub struct List;

/// Declares a field that is a list of items with columns, which get a CSV file of their own.
pub const fn series() -> List {
    List
}

impl List {
    /// Makes the list the series of its row's columns, replacing any other. The field's name comes first in the
    /// pair; `get` returns the list of a row.
    pub fn add<R: 'static, T: Columns>(
        self,
        (name, _): (&'static str, &'static str),
        get: fn(&R) -> &Vec<T>,
        row_columns: &mut ColumnSet<R>,
    ) {
        let ColumnSet { columns, times, ranges, .. } = T::columns();
        row_columns.times.extend(times);
        row_columns.ranges.extend(ranges);
        let names = columns.iter().map(|c| c.name.clone()).collect();
        let items = move |row: &R| {
            let cells = |item: &T| columns.iter().map(|c| c.written(item)).collect();
            get(row).iter().map(cells).collect()
        };
        row_columns.series = Some(Series { name, names, items: Rc::new(items) });
    }
}

/// Declares the struct of a row and its [`Columns`]. Behind the `=` of a field stands the declaration of its column,
/// such as `figure("")`. A field without `=` makes no column.
macro_rules! columns {
    (
        $(#[$about:meta])*
        $vis:vis struct $Row:ident {
            $(
                $(#[$($attribute:tt)+])*
                pub $name:ident: $type:ty $(= $column:expr)?
            ),* $(,)?
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        $vis struct $Row {
            $( $(#[$($attribute)+])* pub $name: $type, )*
        }

        impl $crate::study::columns::Columns for $Row {
            fn columns() -> $crate::study::columns::ColumnSet<Self> {
                let mut set = $crate::study::columns::ColumnSet::default();
                $( $crate::study::columns::column_of!(set, $name, [$(#[$($attribute)+])*] $(, $column)?); )*
                set
            }
        }
    };
}

/// Declares a row as `columns!` does, and the function that makes the row of a measured value. The head `struct Row by
/// function(source: Source)` names the function and its parameter. Behind the `=>` of a field stands the expression
/// that computes the field from the parameter.
macro_rules! measured_columns {
    (
        $(#[$about:meta])*
        $vis:vis struct $Row:ident by $measure:ident($source:ident: $Source:ty) {
            $(
                $(#[$($attribute:tt)+])*
                pub $name:ident: $type:ty = $column:expr => $value:expr
            ),* $(,)?
        }
    ) => {
        $crate::study::columns::columns! {
            $(#[$about])*
            $vis struct $Row {
                $( $(#[$($attribute)+])* pub $name: $type = $column, )*
            }
        }

        impl $Row {
            fn $measure($source: $Source) -> Self {
                Self { $( $name: $value, )* }
            }
        }
    };
}

/// Adds the column of a field to the set `$set`, if the field declares a column.
macro_rules! column_of {
    ($set:ident, $name:ident, [$($about:tt)*]) => {};
    ($set:ident, $name:ident, [$($about:tt)*], $column:expr) => {
        let about = $crate::study::columns::text_of_doc!($($about)*);
        $column.add((stringify!($name), about), |row: &Self| &row.$name, &mut $set);
    };
}

/// Joins the texts of the `#[doc]` attributes among a field's attributes.
macro_rules! text_of_doc {
    () => { "" };
    (#[doc = $text:literal] $($rest:tt)*) => { concat!($text, $crate::study::columns::text_of_doc!($($rest)*)) };
    (#[$($other:tt)+] $($rest:tt)*) => { $crate::study::columns::text_of_doc!($($rest)*) };
}

pub(crate) use {column_of, columns, measured_columns, text_of_doc};

/// The columns of a part that a row may lack; a row without it has no values there.
impl<T: Columns> Columns for Option<T> {
    fn columns() -> ColumnSet<Self> {
        let ColumnSet { columns, times, ranges, .. } = T::columns();
        ColumnSet { columns: columns.iter().map(Column::in_optional).collect(), series: None, times, ranges }
    }
}

impl Columns for HitAgreement {
    fn columns() -> ColumnSet<Self> {
        let mut set = ColumnSet::default();
        let share = || figure("").share();
        share().add(("hit_agreement", ""), |h: &Self| &h.hit_agreement, &mut set);
        share().add(("false", ""), |h: &Self| &h.false_hits, &mut set);
        share().add(("missed", ""), |h: &Self| &h.missed, &mut set);
        share().add(("displaced", ""), |h: &Self| &h.displaced, &mut set);
        figure("").add(("hit_error_px_p50", ""), |h: &Self| &h.hit_error_px_p50, &mut set);
        figure("").add(("hit_error_px_p99", ""), |h: &Self| &h.hit_error_px_p99, &mut set);
        set
    }
}
