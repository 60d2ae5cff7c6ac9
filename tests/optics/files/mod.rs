//! Lens files: what is written comes back, and files of other programs are the lenses that those programs say.

mod formats;
mod hostile;
mod of_optiland;
mod round_trip;
