//! Tools for tests: nothing else of `gpu` depends on them, except that opening a device can install a [`watch`].

pub mod watch;
