//! Errors as codes with a message, and checks of the callers' arguments.
use gobo::Error;
use gobo_scene::SceneError;
use std::{
    cell::RefCell,
    ffi::{CStr, CString, c_char, c_int},
    panic::{AssertUnwindSafe, catch_unwind},
};

const OK: c_int = 0;
const INPUT: c_int = 1;
const SCENE: c_int = 2;
const DEVICE: c_int = 3;
const MEMORY: c_int = 4;
const BUG: c_int = 5;

/// An error on its way to the caller.
#[derive(Debug)]
pub(crate) struct Fault {
    code: c_int,
    message: String,
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::default();
}

impl Fault {
    /// Error of an argument: the problem and the remedy.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { code: INPUT, message: message.into() }
    }

    /// Memory that cannot be allocated [bytes].
    pub(crate) fn memory(bytes: u64) -> Self {
        let message = format!(
            "no memory for {} MiB; use a smaller shadow size, fewer lights, points or pixels",
            bytes >> 20
        );
        Self { code: MEMORY, message }
    }
}

impl From<SceneError> for Fault {
    fn from(error: SceneError) -> Self {
        let code = if matches!(error, SceneError::Memory { .. }) { MEMORY } else { SCENE };
        let help = error.help().map(|help| format!("; {help}")).unwrap_or_default();
        Self { code, message: format!("{error}{help}") }
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        let code = match error {
            Error::Memory(_) => MEMORY,
            Error::Light(_) | Error::Invalid { .. } | Error::Clip(_) => INPUT,
            _ => DEVICE,
        };
        Self { code, message: error.to_string() }
    }
}

/// Runs a function's work, and turns errors and panics into a code and a message.
pub(crate) fn code(work: impl FnOnce() -> Result<(), Fault>) -> c_int {
    // The object that the work was changing is the caller's, who is told to free it.
    let done = catch_unwind(AssertUnwindSafe(work));
    let fault = match done {
        Ok(Ok(())) => return OK,
        Ok(Err(fault)) => fault,
        Err(_) => Fault {
            code: BUG,
            message: "a bug of gobo: its message is on standard error".to_owned(),
        },
    };
    let text = CString::new(fault.message.replace('\0', " ")).unwrap_or_default();
    // The thread may be ending.
    let _ = MESSAGE.try_with(|message| *message.borrow_mut() = text);
    fault.code
}

/// Message of the thread's last failure.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn gobo_message() -> *const c_char {
    MESSAGE.try_with(|message| message.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// The object behind a pointer.
///
/// # Safety
/// It is NULL, or valid for reads for as long as the result is used, and nothing writes to it.
pub(crate) unsafe fn object<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Fault> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(name))
}

/// The object behind a pointer, mutable.
///
/// # Safety
/// It is NULL, or valid for as long as the result is used, and nothing else reads or writes it.
pub(crate) unsafe fn object_mut<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Fault> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_mut() }.ok_or_else(|| null(name))
}

/// An array of `count` elements.
///
/// # Safety
/// It is NULL, or valid for reads of `count` elements for as long as the result is used, and nothing writes
/// to it.
pub(crate) unsafe fn array<'a, T>(
    pointer: *const T,
    count: usize,
    name: &str,
) -> Result<&'a [T], Fault> {
    check_array(pointer, count, name)?;
    // SAFETY: not NULL, aligned and of a possible length as was checked; the rest is the caller's promise.
    Ok(if count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(pointer, count) } })
}

/// A mutable array of `count` elements.
///
/// # Safety
/// It is NULL, or valid for writes of `count` initialised elements for as long as the result is used; nothing
/// else uses it.
pub(crate) unsafe fn array_mut<'a, T>(
    pointer: *mut T,
    count: usize,
    name: &str,
) -> Result<&'a mut [T], Fault> {
    check_array(pointer, count, name)?;
    // SAFETY: not NULL, aligned and of a possible length as was checked; the rest is the caller's promise.
    Ok(if count == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(pointer, count) } })
}

fn check_array<T>(pointer: *const T, count: usize, name: &str) -> Result<(), Fault> {
    let fits =
        count.checked_mul(size_of::<T>()).is_some_and(|bytes| isize::try_from(bytes).is_ok());
    if !fits {
        return Err(Fault::input(format!("{name} has {count} elements, more than memory")));
    }
    if count > 0 && pointer.is_null() {
        return Err(null(name));
    }
    if count > 0 && !pointer.is_aligned() {
        return Err(Fault::input(format!("{name} is not aligned")));
    }
    Ok(())
}

fn null(name: &str) -> Fault {
    Fault::input(format!("{name} is NULL"))
}

/// A text; `None` for NULL.
///
/// # Safety
/// It is NULL, or ends with a zero and is unchanged for as long as the result is used.
pub(crate) unsafe fn text<'a>(
    pointer: *const c_char,
    name: &str,
) -> Result<Option<&'a str>, Fault> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL; the rest is the caller's promise.
    let bytes = unsafe { CStr::from_ptr(pointer) };
    bytes.to_str().map(Some).map_err(|_| Fault::input(format!("{name} is not UTF-8")))
}

/// A required text.
///
/// # Safety
/// As for [`text`].
pub(crate) unsafe fn needed_text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Fault> {
    // SAFETY: the caller's promise.
    unsafe { text(pointer, name) }?.ok_or_else(|| null(name))
}

/// Gives an object to the caller.
///
/// # Safety
/// `out` is NULL, or valid for a write.
pub(crate) unsafe fn give<T>(
    out: *mut *mut T,
    name: &str,
    made: impl FnOnce() -> Result<T, Fault>,
) -> Result<(), Fault> {
    if out.is_null() {
        return Err(null(name));
    }
    // SAFETY: not NULL; the rest is the caller's promise. It holds NULL until there is an object.
    unsafe { out.write(std::ptr::null_mut()) };
    let object = Box::into_raw(Box::new(made()?));
    // SAFETY: as above.
    unsafe { out.write(object) };
    Ok(())
}

/// Frees an object of [`give`].
///
/// # Safety
/// It is NULL, or was given and not yet freed.
pub(crate) unsafe fn free<T>(pointer: *mut T) {
    if !pointer.is_null() {
        // SAFETY: the caller's promise: the pointer is a box's.
        let object = unsafe { Box::from_raw(pointer) };
        // A panic must not reach the caller.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(object)));
    }
}
