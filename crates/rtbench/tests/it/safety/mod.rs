//! What a second attack found, each by name: journals that are edited, results that would be written
//! over, names that give orders to terminals, places that are no files, disks that take no more.

mod journals;
mod occupied;
