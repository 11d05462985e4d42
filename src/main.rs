//! The `invertex` binary: flags, one library call, output.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
