//! Bytes that the process has allocated.

/// As the C library's allocator counts them, for all of its threads; 0 where it does not say. It is Rust's, too.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn allocated() -> u64 {
    type Mallinfo2 = unsafe extern "C" fn() -> libc::mallinfo2;
    // looked up, not linked: glibc has it from 2.33 on
    // SAFETY: the name ends with a zero
    let found = unsafe { libc::dlsym(libc::RTLD_DEFAULT, c"mallinfo2".as_ptr()) };
    if found.is_null() {
        return 0;
    }
    // SAFETY: this is what glibc calls so
    let info = unsafe { std::mem::transmute::<*mut libc::c_void, Mallinfo2>(found)() };
    (info.uordblks + info.hblkhd) as u64
}

/// Other allocators do not say.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(crate) fn allocated() -> u64 {
    0
}

#[cfg(all(test, target_os = "linux", target_env = "gnu"))]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_counted() {
        // other tests allocate and free meanwhile, but not so much; zeros are not written
        let before = allocated();
        let kept = std::hint::black_box(vec![0u8; 1 << 30]);
        let with = allocated().saturating_sub(before);
        assert!(with.abs_diff(kept.len() as u64) < 200 << 20, "{with}");
        drop(kept);
        assert!(allocated().abs_diff(before) < 200 << 20);
    }
}
