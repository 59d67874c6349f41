//! A table of the objects that callers have, by their addresses. A call refuses a handle, with a sentence, if the
//! object was destroyed, is of another type, or is used by another call: reading memory through such a handle would be
//! undefined behaviour.

use crate::border::{Failure, Outcome};
use std::any::{TypeId, type_name};
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// An object that a caller has: its type, how many calls read it now, and whether a call changes it now.
struct Object {
    kind: TypeId,
    readers: usize,
    is_written: bool,
}

/// The objects that callers have, by their addresses.
static OBJECTS: Mutex<BTreeMap<usize, Object>> = Mutex::new(BTreeMap::new());

/// Locks the table of objects.
fn objects() -> MutexGuard<'static, BTreeMap<usize, Object>> {
    // The table is whole even after a panic in another thread, since no statement leaves it half changed.
    OBJECTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Enters into the table an object that a caller is about to get.
pub fn add<T: 'static>(object: *const T) {
    objects().insert(object as usize, Object { kind: TypeId::of::<T>(), readers: 0, is_written: false });
}

/// Removes from the table an object that is about to be destroyed.
///
/// # Errors
/// [`Failure::usage`] for an object that is not in the table, or that a call uses.
pub fn remove<T: 'static>(object: *const T) -> Outcome<()> {
    let mut table = objects();
    let known = find_object("object", object, &mut table)?;
    if known.readers > 0 || known.is_written {
        return Err(in_use("object"));
    }
    table.remove(&(object as usize));
    Ok(())
}

/// Finds an object of the type `T` in the table by its address. Fails for NULL, and if no such object is at the
/// address.
fn find_object<'o, T: 'static>(
    argument: &str,
    object: *const T,
    table: &'o mut BTreeMap<usize, Object>,
) -> Outcome<&'o mut Object> {
    if object.is_null() {
        return Err(Failure::usage(format!("the argument {argument} is NULL")));
    }
    table.get_mut(&(object as usize)).filter(|known| known.kind == TypeId::of::<T>()).ok_or_else(|| {
        let name = type_name::<T>().rsplit("::").next().unwrap_or_default();
        Failure::usage(format!("the argument {argument} is no {name}: it was destroyed, or never made"))
    })
}

/// Makes the failure of a call on an object that another call uses.
fn in_use(argument: &str) -> Failure {
    Failure::usage(format!("the argument {argument} is used by another call at the same time"))
}

/// An object that a call reads. Other calls may read the object at the same time; none may change it until this value
/// is dropped.
pub struct Read<'a, T>(&'a T);

/// An object that a call changes. No other call may use the object until this value is dropped.
pub struct Written<'a, T>(&'a mut T);

/// Begins to read an object.
///
/// # Safety
/// If the table has an object of this type at the address, the object is freed only after [`remove`].
pub unsafe fn read<'a, T: 'static>(argument: &str, object: *const T) -> Outcome<Read<'a, T>> {
    let mut table = objects();
    let known = find_object(argument, object, &mut table)?;
    if known.is_written {
        return Err(in_use(argument));
    }
    known.readers += 1;
    // SAFETY: by the contract, the object is there, and nobody removes or changes it while it is read.
    Ok(Read(unsafe { &*object }))
}

/// Begins to read an object; `None` for NULL.
///
/// # Safety
/// The contract is that of [`read`].
pub unsafe fn read_optional<'a, T: 'static>(argument: &str, object: *const T) -> Outcome<Option<Read<'a, T>>> {
    // SAFETY: the caller keeps to the contract of this function.
    if object.is_null() { Ok(None) } else { unsafe { read(argument, object) }.map(Some) }
}

/// Begins to change an object.
///
/// # Safety
/// The contract is that of [`read`].
pub unsafe fn write<'a, T: 'static>(argument: &str, object: *mut T) -> Outcome<Written<'a, T>> {
    let mut table = objects();
    let known = find_object(argument, object, &mut table)?;
    if known.is_written || known.readers > 0 {
        return Err(in_use(argument));
    }
    known.is_written = true;
    // SAFETY: by the contract, the object is there, and nobody else uses it until the result is dropped.
    Ok(Written(unsafe { &mut *object }))
}

impl<T> Deref for Read<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0
    }
}

impl<T> Drop for Read<'_, T> {
    fn drop(&mut self) {
        if let Some(known) = objects().get_mut(&(std::ptr::from_ref(self.0) as usize)) {
            known.readers -= 1;
        }
    }
}

impl<T> Deref for Written<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0
    }
}

impl<T> DerefMut for Written<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.0
    }
}

impl<T> Drop for Written<'_, T> {
    fn drop(&mut self) {
        if let Some(known) = objects().get_mut(&(std::ptr::from_ref(self.0) as usize)) {
            known.is_written = false;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn an_object_has_many_readers_or_one_writer_until_it_is_removed() {
        let object = Box::into_raw(Box::new(7_u64));
        let sentence = |outcome: Outcome<()>| outcome.err().unwrap().sentence;
        // SAFETY: the object is in the table while it is used, and freed after it was removed.
        unsafe {
            assert!(sentence(read("a", object).map(|_| ())).contains("is no u64: it was destroyed, or never made"));
            add(object);
            let (reader, second_reader) = (read("a", object).ok().unwrap(), read("a", object).ok().unwrap());
            assert_eq!((*reader, *second_reader), (7, 7));
            assert!(sentence(write("a", object).map(|_| ())).contains("used by another call"));
            assert!(sentence(remove(object)).contains("used by another call"));
            drop((reader, second_reader));
            *write("a", object).ok().unwrap() += 1;
            assert_eq!(*read("a", object).ok().unwrap(), 8);
            assert!(sentence(read("a", object.cast::<i64>()).map(|_| ())).contains("is no i64"));
            remove(object).ok().unwrap();
            assert!(sentence(write("a", object).map(|_| ())).contains("was destroyed"));
            assert!(sentence(remove(object)).contains("was destroyed"), "once");
            drop(Box::from_raw(object));
        }
    }

    #[test]
    fn threads_that_change_one_object_take_turns_or_are_refused() {
        let object = Box::into_raw(Box::new(0_u64));
        add(object);
        let address = object as usize;
        let taken_turns = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..2000 {
                        // SAFETY: the object lives until all threads are done.
                        if let Ok(mut value) = unsafe { write("a", address as *mut u64) } {
                            *value += 1;
                            taken_turns.fetch_add(1, Ordering::Relaxed);
                        }
                    }
                });
            }
        });
        remove(object).ok().unwrap();
        // SAFETY: no thread uses it any more.
        let value = unsafe { *Box::from_raw(object) };
        assert_eq!(value, taken_turns.load(Ordering::Relaxed) as u64, "a change was lost");
        assert!(value > 0);
    }
}
