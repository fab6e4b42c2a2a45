//! The `rtbench` command: everything is in the library.

use std::process::ExitCode;

use measurement::system::memory::HugePageHeap;

#[global_allocator]
static HEAP: HugePageHeap = HugePageHeap;

fn main() -> ExitCode {
    rtbench::main()
}
