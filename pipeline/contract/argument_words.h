// Words of a command line, as the argument structs print and parse them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace thixo {

/// One word "--name=value", so that a value may start with a dash, hold blanks, or hold further '='.
void put(std::vector<std::string>& words, const char* name, const std::string& value);
/// "--name" where set.
void put_if(std::vector<std::string>& words, const char* name, bool set);
/// put where the value is not empty.
void put_text(std::vector<std::string>& words, const char* name, const std::string& value);
/// "--" and the path where it is not empty: after "--" no word is an option, so a path may start with a dash.
void put_path(std::vector<std::string>& words, const std::string& path);

/// The word as a shell reads it, in quotes where it needs them.
std::string shell_word(const std::string& word);

/// The one way to take a number from a command line. The value stays as it is where the option is not given.
/// Parsing throws InputError where the word is no number, is not finite, or lies outside [least, most].
struct NumberRange {
    double least, most;
};
void add_number(CLI::App& app, const char* option, double& value, NumberRange range, const char* meaning);

/// The option --threads: whole, from 0 (every core) to 1024.
void add_threads(CLI::App& app, int& threads);
/// The option --seed: whole, from 0 to 2^64 - 1.
void add_seed(CLI::App& app, std::optional<std::uint64_t>& seed);

/// Whether the bytes are UTF-8.
bool is_utf8(std::string_view text);

/// Parses the words (program name left out) by the app. Returns the help text where --help is among them, else nothing.
/// Throws InputError.
std::string parse_words(CLI::App& app, std::vector<std::string> words);

}  // namespace thixo
