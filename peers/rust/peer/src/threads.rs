//! Pools of threads for libraries that build with rayon.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Of the first thread of a program, mostly: builders recurse.
const STACK: usize = 8 << 20;

/// The pool of so many threads, started when it is first asked for.
pub(crate) fn pool(threads: usize) -> Result<Arc<ThreadPool>, String> {
    static POOLS: Mutex<Vec<Arc<ThreadPool>>> = Mutex::new(Vec::new());
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.iter().find(|pool| pool.current_num_threads() == threads) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
    let pool = Arc::new(pool.map_err(|error| error.to_string())?);
    pools.push(Arc::clone(&pool));
    Ok(pool)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pools_have_the_threads_that_are_asked_for() {
        for threads in [1, 3, 1] {
            let asked = pool(threads).unwrap();
            assert_eq!(asked.install(rayon::current_num_threads), threads);
        }
        assert!(Arc::ptr_eq(&pool(3).unwrap(), &pool(3).unwrap()));
    }
}
