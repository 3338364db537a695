#include "pipeline/contract/argument_words.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "pipeline/base/error.h"

namespace thixo {

void put(std::vector<std::string>& words, const char* name, const std::string& value) {
    words.push_back(fmt::format("--{}={}", name, value));
}

void put_if(std::vector<std::string>& words, const char* name, bool set) {
    if (set) words.push_back(fmt::format("--{}", name));
}

void put_text(std::vector<std::string>& words, const char* name, const std::string& value) {
    if (!value.empty()) put(words, name, value);
}

void put_path(std::vector<std::string>& words, const std::string& path) {
    if (path.empty()) return;
    words.push_back("--");
    words.push_back(path);
}

std::string parse_words(CLI::App& app, std::vector<std::string> words) {
    const auto options_end = std::find(words.begin(), words.end(), "--");
    if (std::any_of(words.begin(), options_end, [](const std::string& w) { return w == "-h" || w == "--help"; }))
        return app.help();
    std::reverse(words.begin(), words.end());  // CLI11 pops words from the back
    try {
        app.parse(std::move(words));
    } catch (const CLI::ParseError& e) {
        throw InputError("{}: {}; --help lists the arguments", app.get_name(), e.what());
    }
    return {};
}

}  // namespace thixo
