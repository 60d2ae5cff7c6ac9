//! Exit codes: scripts tell by them what to do next. Those from 70 on are of sysexits.h.

/// The answer of a question is no; or there is an image in spite of errors (`--keep-going`).
pub(crate) const ANSWER_IS_NO: u8 = 1;

/// The answer of a question is neither yes nor no.
pub(crate) const CANNOT_TELL: u8 = 3;

/// Input that cannot be used, on this machine or any other.
pub(crate) const BAD_INPUT: u8 = 2;

/// A mistake in fstop (EX_SOFTWARE).
pub(crate) const BUG: u8 = 70;

/// Input or output failed here; another machine may have more luck (EX_IOERR).
pub(crate) const IO_FAILED: u8 = 74;

/// An interrupted render that its checkpoint continues (EX_TEMPFAIL).
pub(crate) const INTERRUPTED: u8 = 75;

/// An interrupted render without a checkpoint, as shells give it for SIGINT.
pub(crate) const LOST: u8 = 130;

/// The codes, for `--help`.
macro_rules! exit_codes {
    () => {
        "Exit codes:
  0    done; compare, suite: the images agree
  1    compare: the images differ; suite: one does, is new, missing or failed; suite plan: no number is enough;
       merge: shards are missing, or another round is needed; render --keep-going: an image in spite of errors
  2    bad input: the same command will never work
  3    compare, suite: it cannot be told whether the images agree: their noise would hide anything
  70   a bug in fstop
  74   a file could not be read or written on this machine: try again elsewhere
  75   interrupted: the same command continues from the checkpoint
  130  interrupted without a checkpoint: the same command starts anew"
    };
}
pub(super) use exit_codes;
