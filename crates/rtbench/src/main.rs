//! The `rtbench` command: everything is in the library.

use std::process::ExitCode;

use measurement::system::huge_pages::HugePageHeap;

#[global_allocator]
static HEAP: HugePageHeap = HugePageHeap;

fn main() -> ExitCode {
    rtbench::main()
}
