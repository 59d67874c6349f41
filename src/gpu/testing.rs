//! Tools for tests, apart from the rest of `gpu`: nothing else depends on them, except that opening a device can
//! install a [`watch`].

pub mod watch;
