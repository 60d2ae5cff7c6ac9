//! The C interface of Open Image Denoise, versions 1.4 to 2 (its documentation, "API Reference").

use super::DenoiseError;
use crate::math::{Rgb, UVec2};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

/// Names that the library has on the systems that there are.
const NAMES: [&str; 6] = [
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so.1",
    "libOpenImageDenoise.so",
    "libOpenImageDenoise.2.dylib",
    "libOpenImageDenoise.dylib",
    "OpenImageDenoise.dll",
];

/// `OIDN_DEVICE_TYPE_CPU`: the image is in this memory.
const ON_PROCESSORS: c_int = 1;

/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

/// `OIDNDevice`, `OIDNFilter`.
type Handle = *mut c_void;

/// The functions that are used.
#[derive(Clone, Copy, Debug)]
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    release_filter: unsafe extern "C" fn(Handle),
    set_image: unsafe extern "C" fn(
        Handle,
        *const c_char,
        *mut c_void,
        c_int,
        usize,
        usize,
        usize,
        usize,
        usize,
    ),
    set_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
}

/// The loaded library.
#[derive(Debug)]
pub(super) struct Library {
    functions: Functions,
    /// Where they are: it stays loaded as long as this lives.
    _loaded: libloading::Library,
}

impl Library {
    pub(super) fn find() -> Result<Library, DenoiseError> {
        let given = std::env::var_os("FSTOP_OIDN_LIBRARY").filter(|given| !given.is_empty());
        let names: Vec<_> = match given {
            Some(file) => vec![file],
            None => NAMES.map(Into::into).into(),
        };
        let mut reason = String::new();
        for name in &names {
            match Library::load(name) {
                Ok(library) => {
                    // A device that cannot be made is to be noticed before hours of rendering.
                    library.device(1)?;
                    return Ok(library);
                }
                Err(error) => reason = error.to_string(),
            }
        }
        let names: Vec<_> = names.iter().map(|name| name.to_string_lossy()).collect();
        Err(DenoiseError::Missing {
            looked_for: names.join(", "),
            reason,
        })
    }

    #[expect(unsafe_code, reason = "a library in C, which the user has asked for")]
    fn load(name: &std::ffi::OsStr) -> Result<Library, libloading::Error> {
        // SAFETY: what a library does when it is loaded is its own business; the user has asked for this one.
        let loaded = unsafe { libloading::Library::new(name) }?;
        // SAFETY: each function has this type in every version that has its name, by the library's header.
        let functions = unsafe {
            Functions {
                new_device: *loaded.get(b"oidnNewDevice\0")?,
                commit_device: *loaded.get(b"oidnCommitDevice\0")?,
                release_device: *loaded.get(b"oidnReleaseDevice\0")?,
                device_error: *loaded.get(b"oidnGetDeviceError\0")?,
                // The second names are version 1's.
                device_int: *loaded
                    .get(b"oidnGetDeviceInt\0")
                    .or_else(|_| loaded.get(b"oidnGetDevice1i\0"))?,
                set_device_int: *loaded
                    .get(b"oidnSetDeviceInt\0")
                    .or_else(|_| loaded.get(b"oidnSetDevice1i\0"))?,
                new_filter: *loaded.get(b"oidnNewFilter\0")?,
                release_filter: *loaded.get(b"oidnReleaseFilter\0")?,
                set_image: *loaded.get(b"oidnSetSharedFilterImage\0")?,
                set_bool: *loaded
                    .get(b"oidnSetFilterBool\0")
                    .or_else(|_| loaded.get(b"oidnSetFilter1b\0"))?,
                commit_filter: *loaded.get(b"oidnCommitFilter\0")?,
                execute_filter: *loaded.get(b"oidnExecuteFilter\0")?,
            }
        };
        Ok(Library {
            functions,
            _loaded: loaded,
        })
    }

    /// What it is, with its version.
    pub(super) fn name(&self) -> String {
        let version = self.device(1).map_or(0, |device| device.version());
        let (major, minor, patch) = (version / 10_000, version / 100 % 100, version % 100);
        format!("Open Image Denoise {major}.{minor}.{patch}")
    }

    /// A device that works with so many threads.
    #[expect(unsafe_code, reason = "a library in C")]
    pub(super) fn device(&self, threads: usize) -> Result<Device<'_>, DenoiseError> {
        let functions = &self.functions;
        // SAFETY: the type of device is one that the library knows.
        let handle = unsafe { (functions.new_device)(ON_PROCESSORS) };
        let device = Device { handle, functions };
        if handle.is_null() {
            return Err(device.error());
        }
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the device is there, and the name ends in a zero.
        unsafe {
            (functions.set_device_int)(handle, c"numThreads".as_ptr(), threads);
            (functions.commit_device)(handle);
        }
        device.checked()
    }
}

/// What a filter is to do.
pub(super) struct Filter<'a> {
    /// Images by the library's names, of the same size.
    pub(super) inputs: &'a [(&'a str, &'a [Rgb])],
    /// Colors may be brighter than 1.
    pub(super) is_hdr: bool,
    /// Albedo and normals have no noise.
    pub(super) has_clean_features: bool,
}

/// What the library works with.
pub(super) struct Device<'a> {
    handle: Handle,
    functions: &'a Functions,
}

impl Device<'_> {
    #[expect(unsafe_code, reason = "a library in C")]
    fn version(&self) -> c_int {
        // SAFETY: the device is there, and the name ends in a zero.
        unsafe { (self.functions.device_int)(self.handle, c"version".as_ptr()) }
    }

    fn checked(self) -> Result<Self, DenoiseError> {
        match self.failure() {
            None => Ok(self),
            Some(message) => Err(DenoiseError::Failed(message)),
        }
    }

    fn error(&self) -> DenoiseError {
        let unknown = || "it does not say what is wrong".to_string();
        DenoiseError::Failed(self.failure().unwrap_or_else(unknown))
    }

    /// What has gone wrong since this was last asked; without a device, with making one.
    #[expect(unsafe_code, reason = "a library in C")]
    fn failure(&self) -> Option<String> {
        let mut message = ptr::null();
        // SAFETY: a null pointer represents no device, and the message is written to a pointer that is there.
        let code = unsafe { (self.functions.device_error)(self.handle, &mut message) };
        if code == 0 {
            return None;
        }
        if message.is_null() {
            return Some(format!("error {code}"));
        }
        // SAFETY: it ends in a zero, and lasts until the library is asked again.
        let message = unsafe { CStr::from_ptr(message) };
        Some(message.to_string_lossy().into_owned())
    }

    /// Runs a filter on images of this size; the result is called `output`, or is that of the one input.
    #[expect(unsafe_code, reason = "a library in C")]
    pub(super) fn run(
        &self,
        filter: &Filter,
        what: &str,
        size: UVec2,
    ) -> Result<Vec<Rgb>, DenoiseError> {
        let (width, height) = (size.x as usize, size.y as usize);
        let mut output = vec![Rgb::ZERO; width * height];
        if filter
            .inputs
            .iter()
            .any(|(_, values)| values.len() != output.len())
        {
            return Err(DenoiseError::Failed(format!(
                "images of several sizes ({what})"
            )));
        }
        let functions = self.functions;
        // SAFETY: the device is there, and the name ends in a zero.
        let handle = unsafe { (functions.new_filter)(self.handle, c"RT".as_ptr()) };
        if handle.is_null() {
            return Err(self.error());
        }
        let set_image = |name: &str, pixels: *mut Rgb| {
            let name = CString::new(name).unwrap_or_default();
            // SAFETY: there are width × height pixels of three floats (`Rgb` is `repr(C)`) without gaps; the filter only reads those
            // of inputs, and is released before any of them.
            unsafe {
                (functions.set_image)(
                    handle,
                    name.as_ptr(),
                    pixels.cast(),
                    FLOAT3,
                    width,
                    height,
                    0,
                    0,
                    0,
                );
            }
        };
        for (name, values) in filter.inputs {
            set_image(name, values.as_ptr().cast_mut());
        }
        set_image("output", output.as_mut_ptr());
        // SAFETY: the filter is there with all its images, and names end in a zero.
        unsafe {
            (functions.set_bool)(handle, c"hdr".as_ptr(), filter.is_hdr);
            (functions.set_bool)(handle, c"cleanAux".as_ptr(), filter.has_clean_features);
            (functions.commit_filter)(handle);
            (functions.execute_filter)(handle);
            (functions.release_filter)(handle);
        }
        match self.failure() {
            None => Ok(output),
            Some(message) => Err(DenoiseError::Failed(message)),
        }
    }
}

impl Drop for Device<'_> {
    #[expect(unsafe_code, reason = "a library in C")]
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: it is there, and nobody else has it.
            unsafe { (self.functions.release_device)(self.handle) }
        }
    }
}
