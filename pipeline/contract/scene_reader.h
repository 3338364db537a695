// The visitor that fills the scene's structs from a tree, noting everything that is wrong.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/scene_problems.h"
#include "pipeline/contract/scene_value.h"

namespace thixo::scene {

/// Where each key path (materials.water.density) stands, for checks that concern several keys.
using Where = std::map<std::string, Position, std::less<>>;

struct ReadContext {
    Problems& problems;
    Files files = Files::check;
    Where where;
    std::set<std::string> closed = {};  // files that the scene may not have opened; they are problems already
};

/// Reads the keys of one map; visit(reader, struct) calls it key by key, then report_unknown tells what it was not
/// asked for. A key that is wrong keeps the member's default.
class BlockReader {
  public:
    /// `name` is how messages call the block; `at` where it stands, for keys that are missing.
    BlockReader(const Value& map, std::string path, const Position& at, ReadContext& context);

    void key(const char* name, double& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, int& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, std::uint64_t& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, bool& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, std::string& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, Vec2d& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, Vec3d& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, std::optional<Vec3d>& member, const char* unit, Check check, const char* meaning);
    void key(const char* name, std::vector<Vec2d>& member, const char* unit, Check check, const char* meaning);
    template <class E>
    requires std::is_enum_v<E>
    void key(const char* name, E& member, const char*, Check check, const char*) {
        const std::vector<std::string> words(Words<E>::list.begin(), Words<E>::list.end());
        if (const int k = word(name, words, check); k >= 0) member = static_cast<E>(k);
    }
    void reference(const char* name, std::string& member, Refers, Check check, const char* meaning);
    void file(const char* name, std::string& member, Check check, const char* meaning);

    template <class F>
    void group(const char* name, const char*, F&& f) {
        const Value* value = take(name, {});
        if (!value || !is_block(*value, name)) return;
        BlockReader inner(*value, child(name), value->at, context_);
        f(inner);
        inner.report_unknown();
    }
    template <class T>
    void block(const char* name, T& member, const char* meaning) {
        group(name, meaning, [&](BlockReader& r) { visit(r, member); });
    }
    template <class T>
    void named(const char* name, std::vector<T>& member, const char*) {
        for_each_entry(name, [&](const Label& label, const Value& value, const std::string& path) {
            T& entry = member.emplace_back();
            entry.name = label.text;
            BlockReader inner(value, path, label.at, context_);
            visit(inner, entry);
            inner.report_unknown();
        });
    }
    template <class T>
    void list(const char* name, std::vector<T>& member, const char*) {
        const Value* value = take(name, {});
        if (!value || !is_list(*value, name)) return;
        for (std::size_t k = 0; k < value->items.size(); ++k) {
            const std::string path = child(name) + "." + std::to_string(k);
            if (!is_block(value->items[k], path)) continue;
            BlockReader inner(value->items[k], path, value->items[k].at, context_);
            visit(inner, member.emplace_back());
            inner.report_unknown();
        }
    }
    void shape(const char* name, Shape& member, Check check, const char* meaning);
    void shapes(const char* name, std::vector<Shape>& member, Check check, const char* meaning);
    void named_shapes(const char* name, std::vector<std::pair<std::string, Shape>>& member, const char* meaning);

    /// `also`: a key that is handled before anything is read, for suggestions.
    void report_unknown(const char* also = nullptr);

  private:
    const Value* take(const char* name, Check check);
    std::string child(std::string_view name) const {
        return path_.empty() ? std::string(name) : path_ + "." + std::string(name);
    }
    void wrong_type(const Value& value, std::string_view name, const char* wanted);
    bool is_block(const Value& value, std::string_view name);
    bool is_list(const Value& value, std::string_view name);
    bool number(const Value& value, std::string_view name, const char* unit, Check check, double& result);
    bool numbers(const Value& value, std::string_view name, const char* unit, Check check, int count, const char* form,
                 double* result);
    bool in_range(const Value& value, std::string_view name, const char* unit, Check check, double number);
    int word(const char* name, const std::vector<std::string>& words, Check check);
    bool word_like(const Value& value, std::string_view name, std::string& result);
    void read_shape(const Value& value, const std::string& path, Shape& shape);
    template <class F>
    void for_each_entry(const char* name, F&& f) {
        const Value* value = take(name, {});
        if (!value || !is_block(*value, name)) return;
        for (std::size_t k = 0; k < value->items.size(); ++k)
            if (entry_is_sound(*value, k, name))
                f(value->labels[k], value->items[k], child(name) + "." + value->labels[k].text);
    }
    bool entry_is_sound(const Value& map, std::size_t k, const char* block);

    const Value& map_;
    std::string path_;
    Position at_;
    ReadContext& context_;
    std::vector<std::string> known_;
};

/// Names of scenes, materials, boundaries and so on: letters, digits, _ and -, not starting with -, at most 64.
bool is_name(std::string_view text);

/// What the check asks for, in words: "above 0", "from 0 to 1"; empty where it asks for nothing.
std::string describe(const Check& check);

}  // namespace thixo::scene
