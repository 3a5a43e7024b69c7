//! Tests of the whole; each file of this folder is one. Nothing is here to be called.
