//! Tests of the whole project, one test target per file or folder. This library is empty.
