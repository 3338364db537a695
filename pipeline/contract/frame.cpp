#include "pipeline/contract/frame.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/contract/json_fields.h"
#include "pipeline/contract/manifest.h"
#include "pipeline/contract/shortfall_json.h"

namespace thixo {
namespace {

constexpr std::int64_t kLargestId = INT32_MAX;

/// JSON has no word for infinity: a total that is not finite has to stop here, not at the reader.
void require_finite(const Json& value, const std::string& path, int frame) {
    if (value.is_number_float() && !std::isfinite(value.get<double>()))
        throw DivergedError("frame {}: {} is not finite; use a smaller time step", frame, path);
    if (value.is_structured())
        for (const auto& item : value.items())
            require_finite(item.value(),
                           path + (value.is_array() ? "[" : ".") + item.key() + (value.is_array() ? "]" : ""), frame);
}

const char* word_of(TrimNode::Op op) {
    return op == TrimNode::Op::all ? "all" : op == TrimNode::Op::any ? "any" : "except";
}

Json trim_json(const TrimNode& node) {
    Json json;
    if (node.op == TrimNode::Op::sheet) {
        json["sheet"] = node.sheet;
    } else {
        Json parts = Json::array();
        for (const TrimNode& part : node.parts) parts.push_back(trim_json(part));
        json[word_of(node.op)] = std::move(parts);
    }
    if (node.reach > 0) json["within"] = node.reach;
    return json;
}

TrimNode parse_trim(const Json& j, const JsonPlace& place, int depth = 0) {
    constexpr int kDeepest = 64;
    object_or_fail(j, place);
    if (depth > kDeepest) throw CacheError("{}: {} is nested too deep", place.file, place.path);
    TrimNode node;
    if (j.contains("within")) {
        node.reach = static_cast<float>(number_at(j, "within", place));
        if (!(node.reach > 0)) throw CacheError("{}: {}.within is not above 0", place.file, place.path);
    }
    if (j.contains("sheet")) {
        node.sheet = static_cast<int>(integer_at(j, "sheet", 0, kLargestId, place));
        return node;
    }
    for (const TrimNode::Op op : {TrimNode::Op::all, TrimNode::Op::any, TrimNode::Op::except}) {
        if (!j.contains(word_of(op))) continue;
        node.op = op;
        const Json& parts = array_at(j, word_of(op), place);
        for (std::size_t k = 0; k < parts.size(); ++k)
            node.parts.push_back(
                parse_trim(parts[k], place.in(std::string(word_of(op)) + "[" + std::to_string(k) + "]"), depth + 1));
        if (!node.parts.empty()) return node;
    }
    throw CacheError("{}: {} is no trim tree", place.file, place.path);
}

Json body_json(const FrameBody& b) {
    Json j = {{"id", b.id}, {"parent", b.parent}, {"name", b.name}, {"material", b.material}};
    if (b.trim) j["trim"] = trim_json(*b.trim);
    return j;
}

Json obstacle_json(const FrameObstacle& o) {
    return {{"name", o.name},           {"look", o.look},         {"asset", o.asset},
            {"transform", o.transform}, {"velocity", o.velocity}, {"angular_velocity", o.angular_velocity}};
}

Json front_json(const FrameFront& f) { return {{"closed", f.closed}, {"nodes", f.nodes}}; }

Json totals_json(const FrameTotals& t) {
    return {{"mass", t.mass},
            {"momentum", t.momentum},
            {"angular_momentum", t.angular_momentum},
            {"kinetic_energy", t.kinetic_energy},
            {"potential_energy", t.potential_energy},
            {"particle_volume", t.particle_volume},
            {"surface_volume", t.surface_volume},
            {"density_error", t.density_error},
            {"air", t.air},
            {"virtual_particles", t.virtual_particles}};
}

FrameBody parse_body(const Json& j, const JsonPlace& place) {
    object_or_fail(j, place);
    FrameBody b;
    b.id = static_cast<int>(integer_at(j, "id", 0, kLargestId, place));
    b.parent = static_cast<int>(integer_at(j, "parent", -1, kLargestId, place));
    b.name = text_at(j, "name", place);
    b.material = text_at(j, "material", place);
    if (j.contains("trim")) b.trim = parse_trim(j["trim"], place.in("trim"));
    return b;
}

FrameObstacle parse_obstacle(const Json& j, const JsonPlace& place) {
    object_or_fail(j, place);
    FrameObstacle o;
    o.name = text_at(j, "name", place);
    o.look = text_at(j, "look", place);
    o.asset = text_at(j, "asset", place);
    o.transform = numbers_at<16>(j, "transform", place);
    o.velocity = numbers_at<3>(j, "velocity", place);
    o.angular_velocity = numbers_at<3>(j, "angular_velocity", place);
    return o;
}

FrameFront parse_front(const Json& j, const JsonPlace& place) {
    object_or_fail(j, place);
    FrameFront f;
    f.closed = bool_at(j, "closed", place);
    for (const Json& node : array_at(j, "nodes", place)) {
        const Json named = {{"node", node}};
        f.nodes.push_back(numbers_at<3>(named, "node", place.in("nodes")));
    }
    return f;
}

FrameTotals parse_totals(const Json& j, const JsonPlace& place) {
    FrameTotals t;
    t.mass = number_at(j, "mass", place);
    t.momentum = numbers_at<3>(j, "momentum", place);
    t.angular_momentum = numbers_at<3>(j, "angular_momentum", place);
    t.kinetic_energy = number_at(j, "kinetic_energy", place);
    t.potential_energy = number_at(j, "potential_energy", place);
    t.particle_volume = number_at(j, "particle_volume", place);
    t.surface_volume = number_at(j, "surface_volume", place);
    t.density_error = number_at(j, "density_error", place);
    t.air = integer_at(j, "air", 0, INT64_MAX, place);
    t.virtual_particles = integer_at(j, "virtual_particles", 0, INT64_MAX, place);
    return t;
}

}  // namespace

std::string print_frame_facts(const Frame& frame) {
    Json json = {{"frame", frame.number},          {"time", frame.time},
                 {"spacing", frame.spacing},       {"particles", frame.particles.count},
                 {"surfels", frame.surfels.count}, {"totals", totals_json(frame.totals)},
                 {"bodies", Json::array()},        {"obstacles", Json::array()}};
    for (const FrameBody& b : frame.bodies) json["bodies"].push_back(body_json(b));
    for (const FrameObstacle& o : frame.obstacles) json["obstacles"].push_back(obstacle_json(o));
    // Most frames have neither, and their files stay as they were before there were these lists.
    for (const FrameFront& f : frame.fronts) json["fronts"].push_back(front_json(f));
    if (!frame.shortfalls.empty()) json["shortfalls"] = shortfalls_json(frame.shortfalls);
    for (const char* key : {"time", "spacing", "totals", "obstacles", "fronts"})
        if (json.contains(key)) require_finite(json[key], key, frame.number);
    return print_json(json, "frame " + std::to_string(frame.number));
}

Frame parse_frame_facts(std::string_view text, const std::string& file) {
    const Json json = parse_json(text, file);
    const JsonPlace place{file, ""};
    object_or_fail(json, place);
    Frame frame;
    frame.number = static_cast<int>(integer_at(json, "frame", 0, kLargestFrameNumber, place));
    frame.time = number_at(json, "time", place);
    frame.spacing = number_at(json, "spacing", place);
    frame.totals = parse_totals(object_at(json, "totals", place), place.in("totals"));
    for (const Json& j : array_at(json, "bodies", place)) frame.bodies.push_back(parse_body(j, place.in("bodies")));
    for (const Json& j : array_at(json, "obstacles", place))
        frame.obstacles.push_back(parse_obstacle(j, place.in("obstacles")));
    if (json.contains("fronts"))
        for (const Json& j : array_at(json, "fronts", place))
            frame.fronts.push_back(parse_front(j, place.in("fronts")));
    if (json.contains("shortfalls")) frame.shortfalls = parse_shortfalls(array_at(json, "shortfalls", place), file);
    return frame;
}

bool is_own_facts(std::string_view text) {
    try {
        parse_frame_facts(text, "");
        return print_json(parse_json(text, ""), "") == text;
    } catch (const Error&) {
        return false;
    }
}

}  // namespace thixo
