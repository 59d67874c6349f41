//! `ssr-fast`: the optimised march of Schmidt 2013 (section 5.4, listing 5): ten pixels forward while
//! before the surface, a tenth of one back while behind.

use super::ssr::{SchmidtMethod, steps};
use super::{MethodInfo, Sees, Setup, Tuning};
use crate::passes::schmidt_trace::March;

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "ssr-fast",
    summary: "the same in steps of ten pixels forward and a tenth back; mirrors only",
    source: "Schmidt 2013, §5.4, listing 5",
    sees: Sees::Screen,
    settings: |base| {
        let blurred = Setup { tuning: Tuning { distance_blur: true, ..Tuning::default() }, ..base };
        [super::full_and_half(base), steps(base, &[2]), vec![blurred]].concat()
    },
    create: |gpu, setup| Ok(Box::new(SchmidtMethod::new(gpu, setup, March::Optimized)?)),
};
