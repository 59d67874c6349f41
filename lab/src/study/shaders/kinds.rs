//! Kinds of the statistics that drivers give about compiled programs. Each driver has its own names for them; by the
//! kinds, tables find the important statistics whatever their names.

/// Kind of a statistic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Registers of an invocation or a subgroup.
    Registers,
    /// Registers that did not fit and were moved to memory.
    Spills,
    /// Bytes of private memory of an invocation or a subgroup.
    Scratch,
    /// Bytes of memory that a workgroup shares.
    Shared,
    /// Bytes of code.
    CodeSize,
    /// Instructions.
    Instructions,
    /// Subgroups that a SIMD unit or a core holds at a time.
    Occupancy,
    /// Cycles estimated by the driver.
    Cycles,
    /// A number that identifies code.
    Digest,
    /// Anything else.
    Other,
}

/// How the values of a statistic over several programs are combined into one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// Sum of the values.
    Sum,
    /// Greatest of the values.
    Greatest,
    /// Least of the values.
    Least,
}

/// Parts of names, in lower case, with their kinds; the first listed part that a name contains decides. RADV and ANV
/// use these names (docs/devices.md), and other drivers may use the same words.
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
    /// Returns the kind of a statistic, by the name that a driver gives it.
    pub fn named(name: &str) -> Self {
        let name = name.to_lowercase();
        NAMES.iter().find(|(part, _)| name.contains(part)).map_or(Self::Other, |(_, kind)| *kind)
    }

    /// Whether tables for people show the statistic.
    pub fn is_main(self) -> bool {
        !matches!(self, Self::Digest | Self::Other)
    }

    /// Returns how the values over the programs of a frame are combined; `None` for kinds for which neither a sum nor
    /// an extreme makes sense.
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
