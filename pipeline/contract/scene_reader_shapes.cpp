#include <fmt/format.h>

#include "pipeline/contract/scene_reader.h"

namespace thixo::scene {
namespace {

std::vector<std::string> kind_names() {
    std::vector<std::string> names;
    for_each_shape_kind([&](const auto& kind) { names.emplace_back(kind.name); });
    return names;
}

}  // namespace

void BlockReader::read_shape(const Value& value, const std::string& path, Shape& shape) {
    shape.where = context_.problems.place(value.at);
    if (value.type != Value::Type::map) {
        context_.problems.add(value.at,
                              fmt::format("a shape needs a block that names its kind, not {}", describe(value)),
                              "write for example {sphere: {radius: 0.1}}");
        return;
    }
    BlockReader reader(value, path, value.at, context_);
    int kinds = 0;
    for_each_shape_kind([&]<class K>(const ShapeKind<K>& kind) {
        const Value* parameters = reader.take(std::string(kind.name).c_str(), {});
        if (!parameters || kinds++ > 0) return;
        // `union: [..]` stands for `union: {shapes: [..]}`
        Value wrapped;
        const bool is_short = !kind.short_key.empty() &&
                              (parameters->type == Value::Type::list || parameters->type == Value::Type::scalar);
        if (is_short) {
            wrapped.at = parameters->at;
            wrapped.at_label({std::string(kind.short_key), parameters->at}) = *parameters;
            parameters = &wrapped;
        }
        if (!reader.is_block(*parameters, kind.name)) return;
        K& result = shape.kind.emplace<K>();
        BlockReader inner(*parameters, path + "." + std::string(kind.name), parameters->at, context_);
        visit(inner, result);
        inner.report_unknown();
    });
    visit(reader, shape);
    reader.report_unknown();
    if (kinds == 0)
        context_.problems.add(value.at, "the shape has no kind",
                              fmt::format("one of {}", fmt::join(kind_names(), ", ")));
    if (kinds > 1)
        context_.problems.add(value.at, "the shape has more than one kind",
                              "combine them by union, intersection or difference");
}

void BlockReader::shape(const char* name, Shape& member, Check check, const char*) {
    if (const Value* value = take(name, check)) read_shape(*value, child(name), member);
}

void BlockReader::shapes(const char* name, std::vector<Shape>& member, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value || !is_list(*value, name)) return;
    if (value->items.empty()) context_.problems.add(value->at, fmt::format("\"{}\" needs at least one shape", name));
    for (std::size_t k = 0; k < value->items.size(); ++k)
        read_shape(value->items[k], fmt::format("{}.{}", child(name), k), member.emplace_back());
}

void BlockReader::named_shapes(const char* name, std::vector<std::pair<std::string, Shape>>& member, const char*) {
    for_each_entry(name, [&](const Label& label, const Value& value, const std::string& path) {
        member.emplace_back(label.text, Shape{});
        read_shape(value, path, member.back().second);
    });
}

}  // namespace thixo::scene
