// Help, the man page, completion and complaints about words that mean nothing: all of them read off the declared
// commands (declare_commands in main.cpp), so that none of them can fall behind.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class ParseError;
}  // namespace CLI

namespace atwood {

// Gives each option that takes a word the name of what it takes ("SCENE", "METHOD", "FILE"): help prints it, and
// completion knows by it what may follow.
void name_values(CLI::App& app);

// Every option that takes a number refuses what is none, what is not finite and what is out of its range.
void check_values(CLI::App& app);
// What is wrong with an option's value, repetition or lack of one; empty: nothing of the kind.
std::string value_words(const CLI::App& app, const CLI::ParseError& error);

// An option as help, man page and completion see it.
struct OptionWords {
  std::vector<std::string> names;  // "-j", "--jobs"; empty: a positional argument
  std::string value;               // "SCENE"; empty: a flag
  std::string doc, preset;         // preset: what stands where it is not given; empty: nothing to say
  bool required = false, many = false;
};
std::vector<OptionWords> options_of(const CLI::App& app);
// The commands that help lists: hidden ones have no group.
std::vector<const CLI::App*> commands_of(const CLI::App& app);

// Of the program (no command), or of one command; wrapped to `width` columns.
std::string help_text(const CLI::App& app, int width);
std::string man_page(const CLI::App& app);  // roff, of the whole program
// For bash, zsh or fish. Throws InputError for another shell.
std::string completion_script(const CLI::App& app, const std::string& shell);

// The command of this name. Throws InputError with the nearest one.
const CLI::App& command_of(const CLI::App& app, const std::string& name);

// What is wrong with the words, where a command or an option is not known: with the nearest known one. Empty: nothing
// of the kind is wrong. `words` are those after the program's name; `app` has parsed them.
std::string unknown_words(const CLI::App& app, const std::vector<std::string>& words);

// `text` in lines of at most `width` columns, each indented; a word that is longer stands alone.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width);

}  // namespace atwood
