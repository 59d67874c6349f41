//! The columns of a study's rows. A row declares each of them once, with `columns!`: its name in records,
//! what it means, how tables show it, and whether it is a figure, which is equal to the bit on every machine, or a time,
//! which is kept apart by device. Tables, CSV files and the comparison of shards follow from that.

use crate::metrics::HitAgreement;
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

/// What a field of a row can be to be a column.
pub trait AsDatum {
    /// The value.
    fn datum(&self) -> Datum;
}

/// Makes datums of types, each by how one is made of a value.
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
    // By its shortest text, 0.1 stays 0.1.
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

/// A value of a row, found anew each time.
type Value<R> = Rc<dyn Fn(&R) -> Datum>;

/// A column of rows of one type.
pub struct Column<R> {
    /// The name in CSV files, which is that of the record's field. A column without a name is in tables alone.
    pub name: String,
    /// The header in tables. A column without a header is in CSV files alone.
    pub title: String,
    /// What it means.
    pub about: &'static str,
    /// How tables show it.
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
    /// A column that only tables have: a value that follows from others.
    pub fn derived<T: AsDatum>(title: &str, digits: usize, value: impl Fn(&R) -> T + 'static) -> Self {
        let form = Form { digits, is_share: false };
        let value: Value<R> = Rc::new(move |row| value(row).datum());
        Self { name: String::new(), title: title.to_owned(), about: "", form, value }
    }

    /// A column that only CSV files have: what a row is of.
    pub fn named<T: AsDatum>(name: &str, value: impl Fn(&R) -> T + 'static) -> Self {
        let value: Value<R> = Rc::new(move |row| value(row).datum());
        Self { name: name.to_owned(), title: String::new(), about: "", form: Form::PLAIN, value }
    }

    /// The value as a table shows it.
    pub fn shown(&self, row: &R) -> String {
        self.form.text(&(self.value)(row))
    }

    /// The value where it is a number.
    pub fn number(&self, row: &R) -> Option<f64> {
        if let Datum::Number(v) = (self.value)(row) { Some(v) } else { None }
    }

    /// A number of the column's kind, such as a mean, as a table shows it.
    pub fn shown_number(&self, number: Option<f64>) -> String {
        self.form.text(&number.datum())
    }

    /// The value as a CSV file has it: a number with all its digits.
    pub fn written(&self, row: &R) -> String {
        match (self.value)(row) {
            Datum::Nothing => String::new(),
            Datum::Text(text) => text,
            Datum::Count(n) => n.to_string(),
            Datum::Number(v) => v.to_string(),
        }
    }

    /// Returns the column for rows that have this one's rows as a part.
    fn within<O: 'static>(&self, get: fn(&O) -> &R) -> Column<O> {
        let Self { name, title, about, form, value } = self.clone();
        Column { name, title, about, form, value: Rc::new(move |row| value(get(row))) }
    }
}

/// The values of the items of a row, found anew each time.
type Items<R> = Rc<dyn Fn(&R) -> Vec<Vec<String>>>;

/// The items of a list that each row has, such as its frames: a CSV file of their own.
pub struct Series<R> {
    /// The field of the record.
    pub name: &'static str,
    /// The names of the items' columns.
    pub names: Vec<String>,
    /// The values of the items of a row, as a CSV file has them.
    pub items: Items<R>,
}

/// Everything that rows of one type have.
pub struct ColumnSet<R> {
    /// The columns, in order.
    pub columns: Vec<Column<R>>,
    /// A list that each row has, if it has one.
    pub series: Option<Series<R>>,
    /// The fields of records, at whatever depth, that are times.
    pub times: BTreeSet<&'static str>,
    /// The fields of records, at whatever depth, with the least and the greatest number that each can be.
    pub ranges: BTreeMap<&'static str, [f64; 2]>,
}

impl<R> Default for ColumnSet<R> {
    fn default() -> Self {
        Self { columns: Vec::new(), series: None, times: BTreeSet::new(), ranges: BTreeMap::new() }
    }
}

/// A type whose fields are columns.
pub trait Columns: Sized + 'static {
    /// Its columns.
    fn columns() -> ColumnSet<Self>;
}

/// A field with one value.
pub struct Scalar {
    title: &'static str,
    form: Form,
    is_time: bool,
    range: [f64; 2],
}

/// What numbers can be unless their column says otherwise.
const NOT_NEGATIVE: [f64; 2] = [0.0, f64::INFINITY];

/// A figure, which is equal to the bit on every machine; `title` is its header in tables, where it has one.
pub const fn figure(title: &'static str) -> Scalar {
    Scalar { title, form: Form { digits: 4, is_share: false }, is_time: false, range: NOT_NEGATIVE }
}

/// A time, or what follows from times, which is kept apart by device.
pub const fn time(title: &'static str) -> Scalar {
    Scalar { title, form: Form { digits: 3, is_share: false }, is_time: true, range: NOT_NEGATIVE }
}

impl Scalar {
    /// The digits that tables show behind the point.
    pub const fn digits(mut self, digits: usize) -> Self {
        self.form.digits = digits;
        self
    }

    /// A share, which tables show in percent.
    pub const fn share(mut self) -> Self {
        self.form.is_share = true;
        self.range = [0.0, 1.0];
        self
    }

    /// A number that may be negative.
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

/// A field whose fields stand beside the others in records.
pub const fn part() -> Part {
    Part { prefix: None }
}

/// A field whose fields stand below it in records; tables put `title` before their headers, and show none without it.
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

/// A field that has times alone, whatever it consists of.
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
    /// Adds the list to what its row has.
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

/// Declares a row: a struct, its fields, and behind `=` what each is as a column. A field without that is none: it says
/// what the row is of. Records are the struct as JSON.
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

/// Declares the columns that follow from something measured: behind `=>`, how each is found in it.
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

/// Adds the column of a field, if it is one.
macro_rules! column_of {
    ($all:ident, $name:ident, [$($about:tt)*]) => {};
    ($all:ident, $name:ident, [$($about:tt)*], $column:expr) => {
        $column.add((stringify!($name), $crate::study::columns::text_of_doc!($($about)*)), |row: &Self| &row.$name, &mut $all);
    };
}

/// The text of doc comments, from the attributes that they are.
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
