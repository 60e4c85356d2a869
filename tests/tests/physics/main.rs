//! Physics of the whole program: scene file in, numbers out, held against closed forms and identities of
//! `docs/theory.md`. Nothing here needs data from outside of the repository.

mod cie_171;
mod closed_forms;
mod furnace;
mod open_scenes;
mod sealed;
mod unequal_patches;
