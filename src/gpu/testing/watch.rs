//! Fault injection and leak detection: counts the objects that live on a device, and makes the n-th allocation or
//! submission fail as a driver would.
//!
//! [`Gpu::open`](crate::gpu::Gpu::open) with a [`Watch`] replaces the device's table of functions by one that asks the
//! watch first (`watch/calls.rs`). The watch therefore sees the memory allocator's calls as well as ours, and no other
//! code knows about it. A call that is made to fail does not reach the driver or the layers. Only a call that waits
//! reaches them nonetheless, so that objects which the host destroys afterwards are no longer in use.

mod calls;

pub(in crate::gpu) use calls::watch_device;

use crate::error::Error;
use ash::vk;
use std::collections::BTreeMap;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

/// The call that fails, counted from 1 since [`Watch::arm`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The n-th call that makes an object or memory, or binds or maps memory: out of device memory.
    Allocation(u64),
    /// The n-th call that submits, waits or fetches results, and all of them after it: device lost.
    Submission(u64),
}

/// Reads `allocation:7` or `submission:7`.
impl FromStr for Fault {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || Error::Usage(format!("{text:?} is no fault; write it as allocation:7 or submission:7"));
        let (kind, n) = text.split_once(':').ok_or_else(wrong)?;
        let n = n.parse().ok().filter(|n| *n > 0).ok_or_else(wrong)?;
        match kind {
            "allocation" => Ok(Self::Allocation(n)),
            "submission" => Ok(Self::Submission(n)),
            _ => Err(wrong()),
        }
    }
}

/// The kinds of objects that live on a device.
const KINDS: [&str; 14] = [
    "device memory",
    "buffers",
    "images",
    "image views",
    "shader modules",
    "pipelines",
    "pipeline layouts",
    "descriptor set layouts",
    "descriptor pools",
    "samplers",
    "query pools",
    "command pools",
    "fences",
    "semaphores",
];

/// Counts of a device's calls and of its living objects, and the number of the call that is to fail; 0 for none.
#[derive(Debug, Default)]
pub struct Watch {
    live: [AtomicI64; KINDS.len()],
    allocations: AtomicU64,
    submissions: AtomicU64,
    failing_allocation: AtomicU64,
    failing_submission: AtomicU64,
    lost: AtomicBool,
}

impl Watch {
    /// Sets the call that is to fail, if any. Counting begins at 1 again, and a lost device works again.
    pub fn arm(&self, fault: Option<Fault>) {
        let (allocation, submission) = match fault {
            None => (0, 0),
            Some(Fault::Allocation(n)) => (n, 0),
            Some(Fault::Submission(n)) => (0, n),
        };
        self.allocations.store(0, Ordering::SeqCst);
        self.submissions.store(0, Ordering::SeqCst);
        self.failing_allocation.store(allocation, Ordering::SeqCst);
        self.failing_submission.store(submission, Ordering::SeqCst);
        self.lost.store(false, Ordering::SeqCst);
    }

    /// Returns how many allocations and submissions there were since [`Self::arm`].
    pub fn calls(&self) -> [u64; 2] {
        [self.allocations.load(Ordering::SeqCst), self.submissions.load(Ordering::SeqCst)]
    }

    /// Returns how many objects of each kind were made and not destroyed; kinds without any are left out.
    pub fn live(&self) -> BTreeMap<&'static str, i64> {
        let counts = self.live.iter().map(|n| n.load(Ordering::SeqCst));
        KINDS.into_iter().zip(counts).filter(|(_, n)| *n != 0).collect()
    }

    /// Counts an allocation, and returns the error if this allocation is to fail.
    fn allocation(&self) -> Result<(), vk::Result> {
        let n = self.allocations.fetch_add(1, Ordering::SeqCst) + 1;
        let fails = n == self.failing_allocation.load(Ordering::SeqCst);
        if fails { Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY) } else { Ok(()) }
    }

    /// Counts a submission or wait, and returns its outcome.
    fn submission(&self) -> Submission {
        if self.lost.load(Ordering::SeqCst) {
            return Submission::Lost;
        }
        let n = self.submissions.fetch_add(1, Ordering::SeqCst) + 1;
        if n == self.failing_submission.load(Ordering::SeqCst) {
            self.lost.store(true, Ordering::SeqCst);
            return Submission::IsLostNow;
        }
        Submission::Works
    }

    /// Counts the objects that a call made, and returns the call's result.
    fn count_made(&self, kind: &str, count: u32, result: vk::Result) -> vk::Result {
        if result == vk::Result::SUCCESS {
            self.add_living(kind, i64::from(count));
        }
        result
    }

    /// Adds to the number of living objects of a kind, if it is one of [`KINDS`].
    fn add_living(&self, kind: &str, count: i64) {
        if let Some(n) = KINDS.iter().position(|k| *k == kind) {
            self.live[n].fetch_add(count, Ordering::SeqCst);
        }
    }
}

/// The outcome of a submission or wait: it works, it is the one at which the device is lost, or it comes later.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Submission {
    Works,
    IsLostNow,
    Lost,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nth_call_fails_and_a_lost_device_stays_lost() {
        let watch = Watch::default();
        watch.arm(Some("allocation:2".parse().unwrap()));
        let results: Vec<_> = (0..3).map(|_| watch.allocation().is_ok()).collect();
        assert_eq!((results, watch.calls()), (vec![true, false, true], [3, 0]));
        watch.arm(Some("submission:2".parse().unwrap()));
        let lost: Vec<_> = (0..3).map(|_| watch.submission() != Submission::Works).collect();
        assert_eq!((lost, watch.allocation()), (vec![false, true, true], Ok(())));
        watch.arm(None);
        assert!(watch.submission() == Submission::Works);
        for wrong in ["", "allocation", "allocation:0", "allocation:x", "memory:1"] {
            assert!(wrong.parse::<Fault>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_kind_that_a_call_names_is_counted() {
        let calls = include_str!("watch/calls.rs");
        let named: Vec<&str> = KINDS.into_iter().filter(|k| calls.matches(&format!("\"{k}\"")).count() > 0).collect();
        assert_eq!(named, KINDS);
        let watch = Watch::default();
        for kind in KINDS {
            for result in [vk::Result::SUCCESS, vk::Result::ERROR_OUT_OF_DEVICE_MEMORY] {
                assert_eq!(watch.count_made(kind, 2, result), result);
            }
            watch.add_living(kind, -1);
            assert_eq!(watch.live()[kind], 1);
        }
    }
}
