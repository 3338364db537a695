// Everything that is wrong with a scene, collected, and told as file:line:column with the line and a caret.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace thixo::scene {

/// A text that values come from.
struct Source {
    std::string name;    // as messages show it
    std::string folder;  // relative paths in it start here; empty: the process's
    std::string text;
    bool is_override = false;  // a --set: changes entries but adds none
};

struct Position {
    int source = -1;           // index into Sources; -1: no place in a text
    int line = 0, column = 0;  // from 1, column in characters
    int length = 1;            // characters to mark
};

class Problems {
  public:
    /// Adds a text and returns its index.
    int add_source(Source source);
    /// Shows another text of the same length in messages about a source.
    void replace_text(int source, std::string text) {
        sources_[static_cast<std::size_t>(source)].text = std::move(text);
    }
    const Source& source(int index) const { return sources_[static_cast<std::size_t>(index)]; }

    /// Notes a problem; `hint` stands behind the caret. Beyond a thousand they are only counted.
    void add(const Position& at, std::string message, std::string hint = {});
    bool any() const { return count_ > 0; }

    /// "file:line:column"
    std::string place(const Position& at) const;

    /// Throws InputError if there is any problem: "<what>: 2 errors", then each of them in order of source and line, at
    /// most 50.
    void throw_if_any(const std::string& what) const;

  private:
    struct Problem {
        Position at;
        std::string message, hint;
    };
    std::string text(const Problem& problem) const;

    std::vector<Source> sources_;
    std::vector<Problem> problems_;
    std::size_t count_ = 0;
};

/// The word nearest to `word` by edits (swap of neighbours included), or nothing where none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

/// "did you mean \"x\"?", or "known: a, b, c" where nothing is near.
std::string suggestion(std::string_view word, const std::vector<std::string>& words);

inline constexpr int kPathShown = 1000;
/// Text of a user in a message: control characters blanked, shortened to so many characters.
std::string shown(std::string_view text, int most = 60);

/// Number of characters of UTF-8 bytes.
int characters(std::string_view text);

}  // namespace thixo::scene
