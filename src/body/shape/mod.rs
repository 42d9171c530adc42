//! Shape functions: each returns a [`Net`](super::Net) whose springs carry sections and whose nodes carry volumes.
