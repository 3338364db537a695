#include "pipeline/contract/scene_yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <unordered_set>

namespace thixo::scene {
namespace {

struct Refused {  // a limit was passed: nothing more is read
    Position at;
    std::string message;
};

/// Builds the tree from the parser's events, which, unlike the library's own tree, show duplicate keys and the places
/// of aliases.
class TreeBuilder : public YAML::EventHandler {
  public:
    TreeBuilder(int source, const std::vector<std::string_view>& lines, Problems& problems)
        : source_(source), lines_(lines), problems_(problems) {}

    Value root;

    void OnDocumentStart(const YAML::Mark&) override {}
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        scalar(Value::Type::null, mark, anchor, "", false);
    }
    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  const std::string& text) override {
        if (tag != "?" && tag != "!" && !tag.empty())
            problems_.add(position(mark, 1), fmt::format("the tag \"{}\" has no meaning in a scene file", shown(tag)));
        scalar(Value::Type::scalar, mark, anchor, text, tag == "!");
    }
    void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        const auto found = anchors_.find(anchor);
        if (found == anchors_.end()) throw Refused{position(mark, 1), "an alias within the very value it stands for"};
        Value copy = found->second.value;
        charge(found->second.cost, position(mark, 1));
        if (depth_of(copy) + open_.size() > kDeepest)
            throw Refused{position(mark, 1), "blocks and lists are nested too deep"};
        attach(std::move(copy));
    }
    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                         YAML::EmitterStyle::value) override {
        open(Value::Type::list, mark, tag, anchor);
    }
    void OnSequenceEnd() override { close(); }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                    YAML::EmitterStyle::value) override {
        open(Value::Type::map, mark, tag, anchor);
    }
    void OnMapEnd() override { close(); }

  private:
    struct Cost {
        std::size_t values = 0, bytes = 0;
    };
    struct Anchored {
        Value value;
        Cost cost;
    };
    struct Open {
        Value value;
        YAML::anchor_t anchor = 0;
        Cost before;
        bool expects_key = true;                       // map
        bool drop = false;                             // map: the key was bad, its value is left out
        Label label;                                   // map: the key whose value comes next
        std::map<std::string, int, std::less<>> seen;  // map: key and its line
    };

    // The library counts bytes; people and editors count characters. Counting goes on from the place before: a file may
    // be one long line.
    Position position(const YAML::Mark& mark, int length) {
        const std::size_t line = static_cast<std::size_t>(std::max(mark.line, 0));
        std::size_t byte = static_cast<std::size_t>(std::max(mark.column, 0));
        if (line >= lines_.size()) return {source_, mark.line + 1, 1, 1};
        byte = std::min(byte, lines_[line].size());
        if (line != counted_line_ || byte < counted_bytes_) {
            counted_line_ = line;
            counted_bytes_ = 0;
            counted_characters_ = 0;
        }
        counted_characters_ += characters(lines_[line].substr(counted_bytes_, byte - counted_bytes_));
        counted_bytes_ = byte;
        return {source_, mark.line + 1, counted_characters_ + 1, std::max(length, 1)};
    }

    void charge(Cost cost, const Position& at) {
        total_.values += cost.values;
        total_.bytes += cost.bytes;
        if (total_.values > kMostValues)
            throw Refused{at, fmt::format("more than {} values, aliases counted in full", kMostValues)};
        if (total_.bytes > 4 * kLargestSceneFile) throw Refused{at, "too much text, aliases counted in full"};
    }

    static std::size_t depth_of(const Value& value) {
        std::size_t deepest = 0;
        for (const Value& item : value.items) deepest = std::max(deepest, depth_of(item));
        return deepest + 1;
    }

    void scalar(Value::Type type, const YAML::Mark& mark, YAML::anchor_t anchor, const std::string& text, bool quoted) {
        Value value;
        value.type = type;
        value.text = text;
        value.quoted = quoted;
        value.at = position(mark, characters(std::string_view(text).substr(0, text.find('\n'))) + (quoted ? 2 : 0));
        if (quoted) require_closing_quote(mark, value.at);
        charge({1, text.size()}, value.at);
        if (anchor) keep(anchor, value, {1, text.size()});
        attach(std::move(value));
    }

    // The library takes a quoted text that is never closed as one that ends with the file.
    void require_closing_quote(const YAML::Mark& mark, const Position& at) const {
        std::size_t line = static_cast<std::size_t>(mark.line), column = static_cast<std::size_t>(mark.column);
        if (line >= lines_.size() || column >= lines_[line].size()) return;
        const char quote = lines_[line][column];
        if (quote != '"' && quote != '\'') return;  // behind an anchor or a tag
        for (++column; line < lines_.size(); ++line, column = 0) {
            const std::string_view text = lines_[line];
            for (; column < text.size(); ++column) {
                if (quote == '"' && text[column] == '\\')
                    ++column;
                else if (quote == '\'' && text[column] == quote && column + 1 < text.size() &&
                         text[column + 1] == quote)
                    ++column;
                else if (text[column] == quote)
                    return;
            }
        }
        throw Refused{at, "the quote is never closed"};
    }

    void keep(YAML::anchor_t anchor, const Value& value, Cost cost) {
        charge(cost, value.at);  // it is held twice
        anchors_[anchor] = {value, cost};
    }

    void open(Value::Type type, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
        const Position at = position(mark, 1);
        if (tag != "?" && tag != "!" && !tag.empty())
            problems_.add(at, fmt::format("the tag \"{}\" has no meaning in a scene file", shown(tag)));
        if (open_.size() >= kDeepest) throw Refused{at, "blocks and lists are nested too deep"};
        charge({1, 0}, at);
        Open entry;
        entry.value.type = type;
        entry.value.at = at;
        entry.anchor = anchor;
        entry.before = total_;
        open_.push_back(std::move(entry));
    }

    void close() {
        Open done = std::move(open_.back());
        open_.pop_back();
        if (done.anchor)
            keep(done.anchor, done.value, {total_.values - done.before.values + 1, total_.bytes - done.before.bytes});
        attach(std::move(done.value));
    }

    void attach(Value value) {
        if (open_.empty()) {
            root = std::move(value);
            return;
        }
        Open& top = open_.back();
        if (top.value.type == Value::Type::list) {
            top.value.items.push_back(std::move(value));
        } else if (top.expects_key) {
            take_key(top, value);
        } else {
            top.expects_key = true;
            if (top.drop) return;
            if (value.type == Value::Type::null) value.at = top.label.at;  // an empty value has no place of its own
            top.value.labels.push_back(top.label);
            top.value.items.push_back(std::move(value));
        }
    }

    void take_key(Open& top, const Value& key) {
        top.expects_key = false;
        top.drop = true;
        if (key.type != Value::Type::scalar) {
            problems_.add(key.at, fmt::format("a key must be a word, not {}", describe(key)));
            return;
        }
        const auto [first, added] = top.seen.emplace(key.text, key.at.line);
        if (!added) {
            problems_.add(key.at, fmt::format("key \"{}\" is given twice in this block", shown(key.text)),
                          fmt::format("first in line {}", first->second));
            return;
        }
        if (top.seen.size() > kMostKeys)
            throw Refused{key.at, fmt::format("more than {} keys in one block", kMostKeys)};
        top.drop = false;
        top.label = {key.text, key.at};
    }

    int source_;
    const std::vector<std::string_view>& lines_;
    Problems& problems_;
    std::vector<Open> open_;
    std::map<YAML::anchor_t, Anchored> anchors_;
    Cost total_;
    std::size_t counted_line_ = 0, counted_bytes_ = 0;
    int counted_characters_ = 0;
};

/// Notes whether a further document holds anything.
class AnyEvent : public YAML::EventHandler {
  public:
    void OnDocumentStart(const YAML::Mark&) override {}
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
    void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
    void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
    void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
    void OnSequenceEnd() override {}
    void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
    void OnMapEnd() override {}
};

std::vector<std::string_view> split_lines(std::string_view text) {
    std::vector<std::string_view> lines;
    while (true) {
        const std::size_t end = text.find('\n');
        lines.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return lines;
        text.remove_prefix(end + 1);
    }
}

// Bytes of the UTF-8 character at the start of `text` that YAML allows, or 0.
std::size_t character_length(std::string_view text) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned char lead = byte(0);
    if (lead < 0x80) return lead >= 0x20 || lead == '\n' || lead == '\r' || lead == '\t' ? 1 : 0;
    const std::size_t length = lead >= 0xc2 && lead < 0xe0   ? 2
                               : lead >= 0xe0 && lead < 0xf0 ? 3
                               : lead >= 0xf0 && lead < 0xf5 ? 4
                                                             : 0;
    if (length == 0 || text.size() < length) return 0;
    for (std::size_t k = 1; k < length; ++k)
        if ((byte(k) & 0xc0) != 0x80) return 0;
    const bool too_long = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xf0 && byte(1) < 0x90);
    const bool no_character = (lead == 0xed && byte(1) >= 0xa0) || (lead == 0xf4 && byte(1) >= 0x90);
    return too_long || no_character ? 0 : length;
}

bool check_bytes(int source, const std::vector<std::string_view>& lines, Problems& problems) {
    for (std::size_t line = 0; line < lines.size(); ++line) {
        const std::string_view text = lines[line];
        for (std::size_t k = 0; k < text.size();) {
            const std::size_t length = character_length(text.substr(k));
            if (length == 0) {
                problems.add({source, static_cast<int>(line) + 1, characters(text.substr(0, k)) + 1, 1},
                             fmt::format("byte 0x{:02x} does not belong to a text in UTF-8",
                                         static_cast<unsigned char>(text[k])),
                             "is this a scene file?");
                return false;
            }
            k += length;
        }
    }
    return true;
}

void add_syntax_problem(int source, const YAML::Exception& e, const std::vector<std::string_view>& lines,
                        Problems& problems) {
    Position at{source, std::max(e.mark.line, 0) + 1, 1, 1};
    const std::size_t line = std::min(static_cast<std::size_t>(at.line - 1), lines.size() - 1);
    at.line = static_cast<int>(line) + 1;
    at.column += characters(lines[line].substr(0, static_cast<std::size_t>(std::max(e.mark.column, 0))));
    const std::string_view indent = lines[line].substr(0, lines[line].find_first_not_of(" \t"));
    if (const std::size_t tab = indent.find('\t'); tab != std::string_view::npos) {
        problems.add({source, at.line, static_cast<int>(tab) + 1, 1}, "a tab in the indentation",
                     "YAML is indented by blanks");
        return;
    }
    problems.add(at, fmt::format("this is no YAML: {}", shown(e.msg)));
}

}  // namespace

std::optional<Value> read_yaml(int source, Problems& problems) {
    const std::string_view text = problems.source(source).text;
    const std::vector<std::string_view> lines = split_lines(text);
    if (!check_bytes(source, lines, problems)) return std::nullopt;
    TreeBuilder builder(source, lines, problems);
    try {
        std::istringstream stream{std::string(text)};
        YAML::Parser parser(stream);
        if (!parser.HandleNextDocument(builder)) {
            problems.add({source, 0, 0, 1}, "the file is empty",
                         "a scene is a map of blocks: materials, bodies, look, ...");
            return std::nullopt;
        }
        AnyEvent rest;
        if (parser.HandleNextDocument(rest)) {
            problems.add({source, 0, 0, 1}, "more than one document in the file",
                         "remove all after the first line \"---\"");
            return std::nullopt;
        }
    } catch (const Refused& refused) {
        problems.add(refused.at, refused.message);
        return std::nullopt;
    } catch (const YAML::Exception& e) {
        add_syntax_problem(source, e, lines, problems);
        return std::nullopt;
    }
    return std::move(builder.root);
}

std::optional<int> open_source(const std::string& path, const Position& from, Problems& problems) {
    namespace fs = std::filesystem;
    const std::string folder = fs::path(path).parent_path().string();
    const auto fail = [&](const std::string& what) {
        // A file that the command line names speaks for itself.
        problems.add(from.source >= 0 ? from : Position{problems.add_source({path, folder, ""}), 0, 0, 1}, what);
        return std::nullopt;
    };
    std::error_code failure;
    const fs::file_status status = fs::status(path, failure);
    if (!fs::exists(status)) return fail(fmt::format("there is no file {}", shown(path, kPathShown)));
    if (fs::is_directory(status)) return fail(fmt::format("{} is a folder, not a file", shown(path, kPathShown)));
    if (!fs::is_regular_file(status)) return fail(fmt::format("{} is no regular file", shown(path, kPathShown)));
    std::ifstream file(path, std::ios::binary);
    if (!file.is_open()) return fail(fmt::format("{} cannot be read", shown(path, kPathShown)));
    std::string text(kLargestSceneFile + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (file.bad()) return fail(fmt::format("{} cannot be read", shown(path, kPathShown)));
    if (text.size() > kLargestSceneFile)
        return fail(fmt::format("{} has more than {} MiB; is it a scene file?", shown(path, kPathShown),
                                kLargestSceneFile >> 20));
    return problems.add_source({path, folder, std::move(text)});
}

}  // namespace thixo::scene
