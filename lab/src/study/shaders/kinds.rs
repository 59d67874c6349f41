//! What drivers' statistics of compiled programs are about, by their names. Each driver has names of its own; a table sorts
//! them, so that the figures that matter stand in one place whatever a driver calls them.

/// What a statistic is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Registers of an invocation or a subgroup.
    Registers,
    /// Registers that did not fit, and were put into memory.
    Spills,
    /// Bytes of memory that an invocation or a subgroup has for itself.
    Scratch,
    /// Bytes of memory that a workgroup shares.
    Shared,
    /// Bytes of code.
    CodeSize,
    /// Instructions.
    Instructions,
    /// Subgroups that a SIMD unit or a core holds at a time.
    Occupancy,
    /// Cycles, as the driver estimates them.
    Cycles,
    /// A number that tells code from other code.
    Digest,
    /// Anything else.
    Other,
}

/// What the values of several programs come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// Their sum.
    Sum,
    /// The greatest.
    Greatest,
    /// The least.
    Least,
}

/// Parts of names in lower case, and what they are about; the first that fits counts. RADV and ANV name their statistics so
/// (docs/devices.md), and other drivers may use the same words.
const NAMES: [(&str, Kind); 21] = [
    ("hash", Kind::Digest),
    ("spill", Kind::Spills),
    ("fill count", Kind::Spills),
    ("fills", Kind::Spills),
    ("gprs", Kind::Registers),
    ("register", Kind::Registers),
    ("grf", Kind::Registers),
    ("scratch", Kind::Scratch),
    ("stack", Kind::Scratch),
    ("local memory", Kind::Scratch),
    ("lds", Kind::Shared),
    ("shared", Kind::Shared),
    ("workgroup memory", Kind::Shared),
    ("code size", Kind::CodeSize),
    ("binary size", Kind::CodeSize),
    ("instruction", Kind::Instructions),
    ("subgroups per simd", Kind::Occupancy),
    ("occupancy", Kind::Occupancy),
    ("latency", Kind::Cycles),
    ("throughput", Kind::Cycles),
    ("cycle", Kind::Cycles),
];

impl Kind {
    /// What a statistic of a driver's name is about.
    pub fn named(name: &str) -> Self {
        let name = name.to_lowercase();
        NAMES.iter().find(|(part, _)| name.contains(part)).map_or(Self::Other, |(_, kind)| *kind)
    }

    /// Whether a table for people shows it.
    pub fn is_main(self) -> bool {
        !matches!(self, Self::Digest | Self::Other)
    }

    /// What it comes to over the programs of a frame; `None` for what no sum and no extreme makes sense of.
    pub fn fold(self) -> Option<Fold> {
        match self {
            Self::Registers | Self::Scratch | Self::Shared => Some(Fold::Greatest),
            Self::Spills | Self::CodeSize | Self::Instructions | Self::Cycles => Some(Fold::Sum),
            Self::Occupancy => Some(Fold::Least),
            Self::Digest | Self::Other => None,
        }
    }
}

impl Fold {
    /// Combines two values into one.
    pub fn join(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Sum => a + b,
            Self::Greatest => a.max(b),
            Self::Least => a.min(b),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_several_drivers_are_sorted() {
        let names = [
            ("Driver pipeline hash", Kind::Digest),
            ("VGPRs", Kind::Registers),
            ("Spilled VGPRs", Kind::Spills),
            ("Scratch size", Kind::Scratch),
            ("LDS size", Kind::Shared),
            ("Code size", Kind::CodeSize),
            ("Subgroups per SIMD", Kind::Occupancy),
            ("Inverse Throughput", Kind::Cycles),
            ("Instruction Count", Kind::Instructions),
            ("Register Count", Kind::Registers),
            ("Shared Memory Size", Kind::Shared),
            ("Local Memory Size", Kind::Scratch),
            ("Binary Size", Kind::CodeSize),
            ("Branches", Kind::Other),
        ];
        for (name, kind) in names {
            assert_eq!(Kind::named(name), kind, "{name}");
        }
    }

    #[test]
    fn values_of_a_frame_are_sums_or_extremes() {
        let folded = |name: &str| Kind::named(name).fold().map(|fold| fold.join(3.0, 5.0));
        assert_eq!(
            ["VGPRs", "Latency", "Subgroups per SIMD", "Hash"].map(folded),
            [Some(5.0), Some(8.0), Some(3.0), None]
        );
    }
}
