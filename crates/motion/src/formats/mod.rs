//! Readers of outside motion files. Each states its source's conventions and converts them to ours.
