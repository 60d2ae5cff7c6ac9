//! The scenes of `tests/scenes/valid` and `tests/scenes/fuzzed`, each folder with its rule: the
//! former render, the latter never make the program panic or hang.

mod fuzzed;
mod mutation;
mod replay;
mod valid;
mod watch;
