//! `completions` and `man`: generated from the same definitions that parse the arguments.

use clap::CommandFactory;
use invertex::{Error, Result};

use super::{Command, print};

/// Print completions for a shell.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  invertex completions bash > ~/.local/share/bash-completion/completions/invertex
  invertex completions zsh > ~/.zfunc/_invertex
  invertex completions fish > ~/.config/fish/completions/invertex.fish")]
pub(super) struct Completions {
    /// The shell.
    shell: clap_complete::Shell,
}

impl Completions {
    pub(super) fn run(&self) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Command::command(), "invertex", &mut script);
        print::text(&String::from_utf8_lossy(&script))
    }
}

/// Print the manual page (roff).
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  invertex man | man -l -                       read it
  invertex man > ~/.local/share/man/man1/invertex.1
  invertex man build | man -l -                 the page of one verb")]
pub(super) struct Man {
    /// Only this verb's page.
    verb: Option<String>,
}

impl Man {
    pub(super) fn run(&self) -> Result<()> {
        let mut command = Command::command();
        command.build();
        let page = match &self.verb {
            None => command,
            Some(verb) => command
                .find_subcommand(verb)
                .cloned()
                .ok_or_else(|| super::bad_option("VERB", format!("there is no verb \"{verb}\"")))?,
        };
        let mut roff = Vec::new();
        clap_mangen::Man::new(page)
            .render(&mut roff)
            .map_err(|source| Error::io("manual page", source))?;
        print::text(&String::from_utf8_lossy(&roff))
    }
}
