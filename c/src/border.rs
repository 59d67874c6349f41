//! What all functions for C share: codes and sentences of failures, structs that begin with their size, texts, and a
//! guard that turns panics into failures.

use crate::live;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How a call ended. `ssct_last_error` has a sentence on every code but SSCT_RESULT_OK.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SsctResult {
    /// The call did what it is for.
    Ok = 0,
    /// An argument is wrong, and the sentence says which. Nothing was done.
    Usage = 1,
    /// The device cannot be used: it has no Vulkan 1.3, a feature is off, or the queue family does not fit.
    NoDevice = 2,
    /// There is not enough memory on the device or on the host.
    Memory = 3,
    /// A Vulkan call failed. The sentence names the call and what the driver returned.
    Vulkan = 4,
    /// The device is lost. Destroying objects is safe.
    DeviceLost = 5,
    /// The device is not done with the frame yet.
    NotReady = 6,
    /// The library has a fault. The object of the call does nothing more; destroy it.
    Internal = 7,
}

/// The failure of a call: the code that the call returns, and the sentence for `ssct_last_error`.
#[derive(Debug)]
pub struct Failure {
    pub code: SsctResult,
    pub sentence: String,
}

/// The result of a step of a call; [`guard`] turns it into the code that the call returns.
pub type Outcome<T> = Result<T, Failure>;

impl Failure {
    /// Makes the failure of a wrong argument.
    pub fn usage(sentence: impl Into<String>) -> Self {
        Self { code: SsctResult::Usage, sentence: sentence.into() }
    }

    /// Makes the failure for a panic, whose message is part of the sentence.
    fn of_panic(payload: &(dyn Any + Send)) -> Self {
        let message = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
        let sentence = format!("ssct has a fault, please report it: {}", message.unwrap_or("it does not say what"));
        Self { code: SsctResult::Internal, sentence }
    }
}

impl From<ssct::Error> for Failure {
    fn from(error: ssct::Error) -> Self {
        use ash::vk::Result as R;
        let code = match &error {
            ssct::Error::NoDevice(_) => SsctResult::NoDevice,
            ssct::Error::Memory { .. } => SsctResult::Memory,
            ssct::Error::Vulkan { result, .. } => match *result {
                R::NOT_READY => SsctResult::NotReady,
                R::ERROR_DEVICE_LOST => SsctResult::DeviceLost,
                R::ERROR_OUT_OF_DEVICE_MEMORY | R::ERROR_OUT_OF_HOST_MEMORY => SsctResult::Memory,
                _ => SsctResult::Vulkan,
            },
            _ => SsctResult::Usage,
        };
        Self { code, sentence: error.to_string() }
    }
}

thread_local! {
    /// The sentence on the last call of this thread that failed.
    static LAST: RefCell<CString> = RefCell::default();
}

/// Returns the sentence, in UTF-8, on the last call of this thread that failed: what is wrong, and where. The sentence is empty
/// before any call has failed, and stays until the next call of this thread fails.
#[unsafe(no_mangle)]
pub extern "C" fn ssct_last_error() -> *const c_char {
    LAST.with_borrow(|sentence| sentence.as_ptr())
}

/// Runs the body of a function for C, and returns the code of the result. Keeps the sentence of a failure for
/// `ssct_last_error`, and turns a panic into a failure.
pub fn guard(run: impl FnOnce() -> Outcome<()>) -> SsctResult {
    // `AssertUnwindSafe` is right, since an object that a panic may have left half changed refuses further use
    // (`Guarded`).
    let outcome = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|payload| Err(Failure::of_panic(&*payload)));
    match outcome {
        Ok(()) => SsctResult::Ok,
        Err(Failure { code, sentence }) => {
            LAST.set(to_c_text(&sentence));
            code
        }
    }
}

/// Runs the body of a function for C that returns a value and not a code. Returns `otherwise` if the body fails.
pub fn value_or<T>(otherwise: T, run: impl FnOnce() -> Outcome<T>) -> T {
    let mut returned = otherwise;
    guard(|| run().map(|value| returned = value));
    returned
}

/// An object behind a handle. After a panic in a call that changed the object, every later use of the object fails.
pub struct Guarded<T> {
    value: T,
    /// Whether a call panicked while it changed the object, or changes the object now.
    is_broken: bool,
}

impl<T> Guarded<T> {
    /// Wraps an object that is not broken.
    pub fn new(value: T) -> Self {
        Self { value, is_broken: false }
    }

    /// Returns the object for reading; fails if the object is broken.
    pub fn get(&self) -> Outcome<&T> {
        if self.is_broken {
            let sentence = "an earlier fault left this object unusable: destroy it".into();
            return Err(Failure { code: SsctResult::Internal, sentence });
        }
        Ok(&self.value)
    }

    /// Runs a function that may change the object. If the function panics, the object stays marked as broken.
    pub fn with<R>(&mut self, run: impl FnOnce(&mut T) -> Outcome<R>) -> Outcome<R> {
        self.get()?;
        self.is_broken = true;
        let outcome = run(&mut self.value);
        self.is_broken = false;
        outcome
    }
}

/// A struct that begins with its size.
///
/// # Safety
/// It is `repr(C)`, its first field is `struct_size: usize`, and any bytes are a value of it.
pub unsafe trait SizedStruct: Copy {
    /// The struct's name in the header.
    const NAME: &'static str;
}

/// Implements [`SizedStruct`] for structs that are `repr(C)`, begin with `struct_size: usize`, and have no other fields
/// than numbers, handles and pointers.
macro_rules! sized_structs {
    ($($name:ident),+) => {$(
        // SAFETY: the caller gives only structs that are as the comment above says.
        unsafe impl $crate::border::SizedStruct for $name {
            const NAME: &'static str = stringify!($name);
        }
    )+};
}
pub(crate) use sized_structs;

/// Copies a struct out of the caller's memory. A struct of a later header may be longer than this library's; such a
/// struct is accepted if all bytes that this library does not know are zero.
///
/// # Safety
/// The pointer is NULL, or points to a struct of the size in bytes that its first field states.
pub unsafe fn copy_struct<T: SizedStruct>(argument: &str, pointer: *const T) -> Outcome<T> {
    // SAFETY: `stated_size` asks the same of the pointer as this function.
    let size = unsafe { stated_size(argument, pointer) }?;
    let known_size = size_of::<T>();
    // SAFETY: by the contract above, the caller's struct has `size` bytes, and `stated_size` checked that this is
    // `known_size` or more.
    let unknown_bytes = unsafe { std::slice::from_raw_parts(pointer.cast::<u8>().add(known_size), size - known_size) };
    if unknown_bytes.iter().any(|byte| *byte != 0) {
        let name = T::NAME;
        return Err(Failure::usage(format!(
            "the {name} of the argument {argument} has fields that this library, version {}, does not know",
            env!("CARGO_PKG_VERSION")
        )));
    }
    // SAFETY: the caller's struct has at least `known_size` bytes, and any bytes are a value of `T`.
    Ok(unsafe { pointer.read_unaligned() })
}

/// Returns the size in bytes that the first field of the caller's struct states. Fails if this size is less than that
/// of `T`, or is greater than any struct's.
///
/// # Safety
/// The contract is that of [`copy_struct`].
pub unsafe fn stated_size<T: SizedStruct>(argument: &str, pointer: *const T) -> Outcome<usize> {
    if pointer.is_null() {
        return Err(Failure::usage(format!("the argument {argument} is NULL")));
    }
    // SAFETY: by the contract, the size comes first.
    let size = unsafe { pointer.cast::<usize>().read_unaligned() };
    let (name, known_size) = (T::NAME, size_of::<T>());
    // No struct is longer than 4096 bytes, so that a caller who states a greater size never set the field.
    if !(known_size..=4096).contains(&size) {
        return Err(Failure::usage(format!(
            "the struct_size of the {name} of the argument {argument} is {size}; \
             it must be sizeof({name}), which is {known_size}"
        )));
    }
    Ok(size)
}

/// Turns a pointer that a call reads into a reference. Fails for NULL, with the argument's name in the sentence.
///
/// # Safety
/// The pointer is NULL or valid for as long as the call lasts.
pub unsafe fn to_reference<'a, T>(argument: &str, pointer: *const T) -> Outcome<&'a T> {
    // SAFETY: the caller keeps to the contract of this function.
    unsafe { pointer.as_ref() }.ok_or_else(|| Failure::usage(format!("the argument {argument} is NULL")))
}

/// Turns a pointer that a call writes to into a reference. Fails for NULL, with the argument's name in the sentence.
///
/// # Safety
/// The pointer is NULL, or valid and nobody else's for as long as the call lasts.
pub unsafe fn to_reference_mut<'a, T>(argument: &str, pointer: *mut T) -> Outcome<&'a mut T> {
    // SAFETY: the caller keeps to the contract of this function.
    unsafe { pointer.as_mut() }.ok_or_else(|| Failure::usage(format!("the argument {argument} is NULL")))
}

/// Returns the caller's array as a slice. NULL is allowed if the count is 0.
///
/// # Safety
/// The pointer is NULL, or points to `count` elements that stay for as long as the call lasts.
pub unsafe fn to_slice<'a, T>(argument: &str, pointer: *const T, count: u32) -> Outcome<&'a [T]> {
    match (count, pointer.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(Failure::usage(format!("the argument {argument} is NULL, and its count is {count}"))),
        // SAFETY: the caller keeps to the contract of this function.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(pointer, count as usize) }),
    }
}

/// Returns the caller's text. Fails for NULL, and for a text that is not UTF-8.
///
/// # Safety
/// The pointer is NULL, or points to a text that ends with a zero byte and stays for as long as the call lasts.
pub unsafe fn read_text<'a>(argument: &str, pointer: *const c_char) -> Outcome<&'a str> {
    if pointer.is_null() {
        return Err(Failure::usage(format!("the argument {argument} is NULL")));
    }
    // SAFETY: the caller keeps to the contract of this function.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Failure::usage(format!("the argument {argument} is no text in UTF-8")))
}

/// Makes a text for the caller, which ends with a zero byte. Zero bytes within the text become spaces.
pub fn to_c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// Makes an object, and writes its address to `to` for the caller, or NULL if `make` fails. The caller later destroys
/// the object by [`destroy`].
///
/// # Safety
/// `to` is NULL, or a valid place for a pointer.
pub unsafe fn create<T: 'static>(argument: &str, to: *mut *mut T, make: impl FnOnce() -> Outcome<T>) -> SsctResult {
    guard(|| {
        // SAFETY: the caller keeps to the contract of this function.
        let to = unsafe { to_reference_mut(argument, to) }?;
        *to = std::ptr::null_mut();
        *to = Box::into_raw(Box::new(make()?));
        live::add(*to);
        Ok(())
    })
}

/// Destroys an object of [`create`]. NULL is allowed, and an object that was destroyed before is refused.
///
/// # Safety
/// If an object that [`create`] made is still at the address, it is of this type.
pub unsafe fn destroy<T: 'static>(object: *mut T) {
    guard(|| {
        if !object.is_null() {
            live::remove(object)?;
            // SAFETY: by the contract; the object was there until now, and no call uses it.
            drop(unsafe { Box::from_raw(object) });
        }
        Ok(())
    });
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[repr(C)]
    #[derive(Clone, Copy)]
    struct Known {
        struct_size: usize,
        value: u32,
    }

    #[repr(C)]
    struct Later {
        known: Known,
        more: u64,
    }

    sized_structs!(Known);

    /// Returns the sentence of `ssct_last_error`.
    fn last_sentence() -> String {
        // SAFETY: the function returns a text.
        unsafe { CStr::from_ptr(ssct_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn a_panic_is_a_code_and_a_sentence_and_the_object_does_nothing_more() {
        let mut object = Guarded::new(1);
        assert_eq!(guard(|| object.with(|_| panic!("a {}", "fault"))), SsctResult::Internal);
        assert!(last_sentence().contains("a fault"), "{}", last_sentence());
        assert_eq!(guard(|| object.with(|_| Ok(()))), SsctResult::Internal);
        assert!(last_sentence().contains("destroy it"), "{}", last_sentence());
        let mut intact = Guarded::new(1);
        assert_eq!(guard(|| intact.with(|_| Err::<(), _>(Failure::usage("no")))), SsctResult::Usage);
        assert_eq!(guard(|| intact.with(|_| Ok(()))), SsctResult::Ok, "an error breaks nothing");
        assert_eq!(value_or(7, || panic!("{}", 1)), 7);
    }

    #[test]
    fn sentences_are_of_the_thread_whose_call_failed() {
        guard(|| Err(Failure::usage("here")));
        std::thread::spawn(|| {
            assert_eq!(last_sentence(), "");
            guard(|| Err(Failure::usage("there \0 and on")));
            assert_eq!(last_sentence(), "there   and on");
        })
        .join()
        .unwrap();
        assert_eq!(last_sentence(), "here");
    }

    #[test]
    fn a_struct_of_another_size_is_taken_or_refused() {
        let known = Known { struct_size: size_of::<Known>(), value: 5 };
        // SAFETY: each struct has the size that it states, except where nothing but the size is read.
        unsafe {
            assert_eq!(copy_struct("a", &known).unwrap().value, 5);
            let sentence_for = |size| copy_struct("a", &Known { struct_size: size, ..known }).err().unwrap().sentence;
            assert!(sentence_for(0).contains("Known of the argument a is 0; it must be sizeof(Known), which is 16"));
            assert!(sentence_for(8).contains("is 8") && sentence_for(usize::MAX).contains("sizeof"));
            // A struct of a later header, whose field `more` this library does not know.
            let copy_later = |more| {
                let later = Later { known: Known { struct_size: size_of::<Later>(), ..known }, more };
                copy_struct("a", (&raw const later).cast::<Known>())
            };
            assert_eq!(copy_later(0).unwrap().value, 5);
            let sentence = copy_later(9).err().unwrap().sentence;
            assert!(sentence.contains("does not know"), "{sentence}");
            assert!(copy_struct::<Known>("a", std::ptr::null()).err().unwrap().sentence.contains("a is NULL"));
        }
    }

    #[test]
    fn every_result_of_the_driver_has_a_code() {
        use ash::vk::Result as R;
        let code = |result| Failure::from(ssct::Error::Vulkan { what: "a call".into(), result }).code;
        assert_eq!(code(R::NOT_READY), SsctResult::NotReady);
        assert_eq!(code(R::ERROR_DEVICE_LOST), SsctResult::DeviceLost);
        assert_eq!(code(R::ERROR_OUT_OF_DEVICE_MEMORY), SsctResult::Memory);
        assert_eq!(code(R::ERROR_INITIALIZATION_FAILED), SsctResult::Vulkan);
        assert_eq!(Failure::from(ssct::Error::NoDevice(String::new())).code, SsctResult::NoDevice);
    }
}
