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
    /// The value as a datum.
    fn datum(&self) -> Datum;
}

/// Implements [`AsDatum`] for types, each by an expression that makes a datum of a value.
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
    // The shortest decimal text keeps 0.1 as 0.1.
    f32: |v| Datum::Number(v.to_string().parse().unwrap_or(f64::NAN)),
    u32: |n| Datum::Count((*n).into()),
    u64: |n| Datum::Count(*n),
    usize: |n| Datum::Count(*n as u64),
    bool: |is| Datum::Text(if *is { "yes" } else { "no" }.to_owned()),
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
    digits: usize,
    is_share: bool,
}

impl Form {
    const PLAIN: Self = Self { digits: 0, is_share: false };

    /// The text of a datum in a table; a share is shown in percent.
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
    /// A column for tables alone, whose value follows from other columns.
    pub fn derived<T: AsDatum>(title: &str, digits: usize, value: impl Fn(&R) -> T + 'static) -> Self {
        let form = Form { digits, is_share: false };
        let value: Value<R> = Rc::new(move |row| value(row).datum());
        Self { name: String::new(), title: title.to_owned(), about: "", form, value }
    }

    /// A column for CSV files alone, which says what a row is about.
    pub fn named<T: AsDatum>(name: &str, value: impl Fn(&R) -> T + 'static) -> Self {
        let value: Value<R> = Rc::new(move |row| value(row).datum());
        Self { name: name.to_owned(), title: String::new(), about: "", form: Form::PLAIN, value }
    }

    /// The value as a table shows it.
    pub fn shown(&self, row: &R) -> String {
        self.form.text(&(self.value)(row))
    }

    /// The value, if it is a number.
    pub fn number(&self, row: &R) -> Option<f64> {
        if let Datum::Number(v) = (self.value)(row) { Some(v) } else { None }
    }

    /// A number of the column's kind, such as a mean, as a table shows it.
    pub fn shown_number(&self, number: Option<f64>) -> String {
        self.form.text(&number.datum())
    }

    /// The value as a CSV file has it; a number has all its digits.
    pub fn written(&self, row: &R) -> String {
        match (self.value)(row) {
            Datum::Nothing => String::new(),
            Datum::Text(text) => text,
            Datum::Count(n) => n.to_string(),
            Datum::Number(v) => v.to_string(),
        }
    }

    /// Returns the column for rows of type `O`, which have a row of type `R` as a part.
    fn within<O: 'static>(&self, get: fn(&O) -> &R) -> Column<O> {
        let Self { name, title, about, form, value } = self.clone();
        Column { name, title, about, form, value: Rc::new(move |row| value(get(row))) }
    }
}

/// Computes the values of the items of a row, each time it is called.
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
    /// The columns of the type.
    fn columns() -> ColumnSet<Self>;
}

/// The declaration of a field with one value, from which a column is made.
pub struct Scalar {
    title: &'static str,
    form: Form,
    is_time: bool,
    range: [f64; 2],
}

/// The range of a column's numbers, unless the column sets another range.
const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];

/// A figure, which is equal to the bit on every machine; `title` is its header in tables, or empty.
pub const fn figure(title: &'static str) -> Scalar {
    Scalar { title, form: Form { digits: 4, is_share: false }, is_time: false, range: NOT_NEGATIVE }
}

/// A time, or a value that follows from times, which is kept apart by device.
pub const fn time(title: &'static str) -> Scalar {
    Scalar { title, form: Form { digits: 3, is_share: false }, is_time: true, range: NOT_NEGATIVE }
}

impl Scalar {
    /// Sets the digits that tables show behind the point.
    pub const fn digits(mut self, digits: usize) -> Self {
        self.form.digits = digits;
        self
    }

    /// Marks a share, which tables show in percent.
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

    /// Adds the field to the columns of its row.
    pub fn add<R: 'static, T: AsDatum + 'static>(
        self,
        (name, about): (&'static str, &'static str),
        get: fn(&R) -> &T,
        to: &mut ColumnSet<R>,
    ) {
        if self.is_time {
            to.times.insert(name);
        }
        to.ranges.insert(name, self.range);
        let (name, title) = (name.to_owned(), self.title.to_owned());
        let form = self.form;
        let value: Value<R> = Rc::new(move |row| get(row).datum());
        to.columns.push(Column { name, title, about, form, value });
    }
}

/// A field whose own fields are columns.
pub struct Part {
    prefix: Option<&'static str>,
}

/// A field whose own fields stand beside the row's other fields in records.
pub const fn part() -> Part {
    Part { prefix: None }
}

/// A field whose own fields are nested in records; tables put `title` before their headers, and leave them out if it is empty.
pub const fn nested(title: &'static str) -> Part {
    Part { prefix: Some(title) }
}

impl Part {
    /// Adds the columns of the field to those of its row.
    pub fn add<R: 'static, T: Columns>(
        self,
        (name, _): (&'static str, &'static str),
        get: fn(&R) -> &T,
        to: &mut ColumnSet<R>,
    ) {
        let own = T::columns();
        to.times.extend(own.times);
        to.ranges.extend(own.ranges);
        to.columns.extend(own.columns.iter().map(|column| {
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

/// A field of times that tables do not show.
pub struct Times;

/// A field of any type that consists of times alone.
pub const fn times() -> Times {
    Times
}

impl Times {
    /// Notes that the field is a time.
    pub fn add<R: 'static, T: 'static>(
        self,
        (name, _): (&'static str, &'static str),
        _get: fn(&R) -> &T,
        to: &mut ColumnSet<R>,
    ) {
        to.times.insert(name);
    }
}

/// A field that is a list.
pub struct List;

/// A field that is a list of items with columns, which get a CSV file of their own.
pub const fn series() -> List {
    List
}

impl List {
    /// Adds the list to the row's columns.
    pub fn add<R: 'static, T: Columns>(
        self,
        (name, _): (&'static str, &'static str),
        get: fn(&R) -> &Vec<T>,
        to: &mut ColumnSet<R>,
    ) {
        let own = T::columns();
        to.times.extend(own.times);
        to.ranges.extend(own.ranges);
        let names = own.columns.iter().map(|c| c.name.clone()).collect();
        let columns = own.columns;
        let items = move |row: &R| {
            let cells = |item: &T| columns.iter().map(|c| c.written(item)).collect();
            get(row).iter().map(cells).collect()
        };
        to.series = Some(Series { name, names, items: Rc::new(items) });
    }
}

/// Declares a row: a struct with its fields, and behind `=` the column that a field makes. A field without `=` is no column; it
/// says what the row is about.
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
                let mut all = $crate::study::columns::ColumnSet::default();
                $( $crate::study::columns::column_of!(all, $name, [$(#[$($attribute)+])*] $(, $column)?); )*
                all
            }
        }
    };
}

/// Declares columns that are computed from a measured value; the expression behind `=>` computes the column from the
/// value.
macro_rules! measured_columns {
    (
        $(#[$about:meta])*
        $vis:vis struct $Row:ident by $find:ident($source:ident: $Source:ty) {
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
            fn $find($source: $Source) -> Self {
                Self { $( $name: $value, )* }
            }
        }
    };
}

/// Adds the column of a field, if the field has one.
macro_rules! column_of {
    ($all:ident, $name:ident, [$($about:tt)*]) => {};
    ($all:ident, $name:ident, [$($about:tt)*], $column:expr) => {
        $column.add((stringify!($name), $crate::study::columns::text_of_doc!($($about)*)), |row: &Self| &row.$name, &mut $all);
    };
}

/// The text of doc comments, from their `#[doc]` attributes.
macro_rules! text_of_doc {
    () => { "" };
    (#[doc = $text:literal] $($rest:tt)*) => { concat!($text, $crate::study::columns::text_of_doc!($($rest)*)) };
    (#[$($other:tt)+] $($rest:tt)*) => { $crate::study::columns::text_of_doc!($($rest)*) };
}

pub(crate) use {column_of, columns, measured_columns, text_of_doc};

impl Columns for HitAgreement {
    fn columns() -> ColumnSet<Self> {
        let mut all = ColumnSet::default();
        let share = || figure("").share();
        share().add(("hit_agreement", ""), |h: &Self| &h.hit_agreement, &mut all);
        share().add(("false", ""), |h: &Self| &h.false_hits, &mut all);
        share().add(("missed", ""), |h: &Self| &h.missed, &mut all);
        share().add(("displaced", ""), |h: &Self| &h.displaced, &mut all);
        figure("").add(("hit_error_px_p50", ""), |h: &Self| &h.hit_error_px_p50, &mut all);
        figure("").add(("hit_error_px_p99", ""), |h: &Self| &h.hit_error_px_p99, &mut all);
        all
    }
}
