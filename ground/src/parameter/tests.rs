use super::*;

choices! {
    enum Colour {
        /// The colour of the sky.
        Blue = "blue",
        /// The colour of roses.
        Red = "red",
    }
}

parameters! {
    struct Inner {
        /// How many.
        how_many: u32 = Parameter::new(7).author(9).within(1, 64),
    }
}

parameters! {
    struct Outer {
        /// The group.
        inner: Inner,
        /// What colour
        /// it has.
        colour: Colour = Parameter::new(Colour::Blue),
        /// A share.
        share: f32 = Parameter::new(0.5).above(0.0, 1.0),
        /// Whether.
        whether: bool = Parameter::new(false),
    }
}

#[test]
fn a_declaration_gives_a_table_and_values_by_name() {
    let table = Outer::table();
    let names: Vec<_> = table.iter().map(|p| p.name).collect();
    assert_eq!(names, ["how_many", "colour", "share", "whether"]);
    assert_eq!((table[1].help.as_str(), table[0].typed_name()), ("What colour it has.", "how-many".to_owned()));
    let mut values = Values::default();
    assert_eq!(Outer::from_values(&values).inner.how_many, 7);
    values.preset = Preset::Author;
    assert_eq!(Outer::from_values(&values).inner.how_many, 9);
    for (parameter, text) in table.iter().zip(["64", "red", "1", "on"]) {
        values.set(parameter, parameter.parse(text).expect("a value"));
    }
    let outer = Outer { inner: Inner { how_many: 64 }, colour: Colour::Red, share: 1.0, whether: true };
    assert_eq!(Outer::from_values(&values), outer);
    assert_eq!(outer.list(), table.iter().map(|p| values.value(p)).collect::<Vec<_>>());
}

#[test]
fn a_value_outside_the_domain_is_refused_in_a_sentence() {
    let table = Outer::table();
    for (parameter, text) in table.iter().zip(["0", "green", "0", "yes"]) {
        let message = parameter.parse(text).expect_err("outside").to_string();
        assert!(message.contains(&parameter.typed_name()) && message.contains("it takes"), "{message}");
    }
    assert!(table[2].parse("NaN").is_err() && table[2].parse("inf").is_err());
}

#[test]
fn only_what_is_changed_is_given() {
    let values = Values::default().with(|p: &mut Outer| p.inner.how_many = 3);
    assert_eq!(values.given_names().collect::<Vec<_>>(), ["how_many"]);
    assert_eq!(Values { preset: Preset::Author, ..values }.with(|_: &mut Outer| ()).given_names().count(), 1);
}
