#include "render/preview/splats.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/trim.h"
#include "render/preview/colour_map.h"

namespace thixo::preview {

namespace {

const PointSet& points_of(const Frame& frame, const std::string& what) {
    return what == "surfels" ? frame.surfels : frame.particles;
}

// "v.x" -> ("v", 0); a name without a component -> (name, -1).
std::pair<std::string, int> split_component(const std::string& attribute) {
    const std::size_t n = attribute.size();
    if (n > 2 && attribute[n - 2] == '.' && attribute[n - 1] >= 'x' && attribute[n - 1] <= 'z')
        return {attribute.substr(0, n - 2), attribute[n - 1] - 'x'};
    return {attribute, -1};
}

bool has_attribute(const PointSet& points, const std::string& attribute) {
    return points.find(attribute) || points.find(split_component(attribute).first);
}

bool is_whole_number(const Attribute& a) {
    return std::holds_alternative<std::vector<std::int32_t>>(a.data) ||
           std::holds_alternative<std::vector<std::int64_t>>(a.data);
}

const char* unit_of(const std::string& name) {
    static constexpr std::pair<const char*, const char*> units[] = {
        {"v", "m/s"}, {"density", "kg/m^3"}, {"pressure", "Pa"},      {"mass", "kg"},        {"pscale", "m"},
        {"P", "m"},   {"rest", "m"},         {"temperature", "degC"}, {"load", "strengths"}, {"von_mises", "Pa"}};
    for (const auto& [known, unit] : units)
        if (name == known) return unit;
    return "";
}

std::string title_of(const std::string& attribute, const Attribute& data) {
    const auto [name, component] = split_component(attribute);
    const bool magnitude = component < 0 && std::holds_alternative<std::vector<Vec3f>>(data.data);
    const std::string unit = unit_of(name);
    return (magnitude ? "|" + attribute + "|" : attribute) + (unit.empty() ? "" : " [" + unit + "]");
}

Vec3f display_colour(const scene::Appearance& a) {
    if (a.type != scene::AppearanceType::dielectric) return encode_srgb(a.colour);
    // A clear liquid has no colour of its own. It is drawn in what light keeps over the depth that takes most of the
    // strongest absorption, or in pale blue.
    const double most = a.absorption.maxCoeff();
    if (!(most > 0)) return {0.36f, 0.62f, 0.86f};
    return encode_srgb(0.9 * (-1.6 * a.absorption.array() / most).exp().matrix());
}

Vec3f material_colour(const scene::Look& look, const std::string& material) {
    for (const scene::Appearance& a : look.appearances)
        if (a.name == material) return display_colour(a);
    return encode_srgb(scene::Appearance{}.colour);
}

void colour_by_material(Splats& splats, const Frame& frame, const PointSet& points, const scene::Look& look) {
    const Attribute* body = points.find("body");
    const auto* ids = body ? std::get_if<std::vector<std::int32_t>>(&body->data) : nullptr;
    const std::uint32_t plain =
        pack_colour(material_colour(look, frame.bodies.empty() ? "" : frame.bodies[0].material));
    std::vector<std::pair<int, std::uint32_t>> colours;
    for (const FrameBody& b : frame.bodies) colours.emplace_back(b.id, pack_colour(material_colour(look, b.material)));
    std::sort(colours.begin(), colours.end());
    parallel_for(points.count, [&](std::size_t i) {
        splats.colour[i] = plain;
        if (!ids) return;
        const auto found =
            std::lower_bound(colours.begin(), colours.end(), std::pair<int, std::uint32_t>((*ids)[i], 0));
        if (found != colours.end() && found->first == (*ids)[i]) splats.colour[i] = found->second;
    });
}

void colour_by_categories(Splats& splats, const std::vector<double>& values, const ValueRange& range) {
    splats.legend.kind = Legend::Kind::categories;
    for (auto value = static_cast<std::int64_t>(range.lower); value <= static_cast<std::int64_t>(range.upper); ++value)
        splats.legend.categories.emplace_back(std::to_string(value), pack_colour(category_colour(value)));
    parallel_for(values.size(), [&](std::size_t i) {
        splats.colour[i] = pack_colour(category_colour(static_cast<std::int64_t>(values[i])));
    });
}

void colour_by_scale(Splats& splats, const std::vector<double>& values, const ValueRange& range) {
    splats.legend.kind = Legend::Kind::scale;
    splats.legend.range = range;
    const double width = range.upper - range.lower;
    parallel_for(values.size(), [&](std::size_t i) {
        const double t = width > 0 ? (values[i] - range.lower) / width : 0.5 + 0 * values[i];  // keeps a NaN one
        splats.colour[i] = pack_colour(map_colour(t));
    });
}

void colour_by_value(Splats& splats, const PointSet& points, const std::string& attribute,
                     const std::optional<ValueRange>& range) {
    const Attribute* whole = points.find(attribute);
    const Attribute* data = whole ? whole : points.find(split_component(attribute).first);
    const std::vector<double> values = attribute_values(points, attribute);
    const ValueRange own = range ? *range : attribute_range(points, attribute);
    splats.legend.title = title_of(attribute, *data);
    if (own.empty()) return;  // no point has a finite value
    if (is_whole_number(*data) && own.upper - own.lower < 10)
        colour_by_categories(splats, values, own);
    else
        colour_by_scale(splats, values, own);
}

// Colours that are stored: Cd as linear colours, N as 1/2 + n/2.
bool colour_by_vectors(Splats& splats, const PointSet& points, const std::string& attribute) {
    if (attribute != "Cd" && attribute != "N") return false;
    const Attribute* a = points.find(attribute);
    const auto* vectors = a ? std::get_if<std::vector<Vec3f>>(&a->data) : nullptr;
    if (!vectors) return false;
    const bool normals = attribute == "N";
    parallel_for(points.count, [&](std::size_t i) {
        const Vec3f& x = (*vectors)[i];
        if (!normals && x.minCoeff() < 0) return;  // of no coloured mesh: as its material
        splats.colour[i] =
            pack_colour(normals ? Vec3f((0.5f * x.array() + 0.5f).matrix()) : encode_srgb(x.cast<double>()));
    });
    if (normals) splats.legend.title = "N as colour";
    return true;
}

/// Faces of cracks get a colour for each crack. All other surfels stay as their material, but small: cracks lie within
/// the body, and are seen between them.
bool colour_by_cracks(Splats& splats, const PointSet& points, const std::string& attribute) {
    const Attribute* a = attribute == "sheet" ? points.find(attribute) : nullptr;
    const auto* sheets = a ? std::get_if<std::vector<std::int32_t>>(&a->data) : nullptr;
    if (!sheets || splats.axes.empty()) return false;
    constexpr float kSmall = 0.2f;
    parallel_for(points.count, [&](std::size_t i) {
        const std::int32_t sheet = (*sheets)[i];
        // Both faces of a crack have a sheet of their own.
        if (sheet >= kFirstCrackSheet)
            splats.colour[i] = pack_colour(category_colour((sheet - kFirstCrackSheet) / 2));
        else
            for (const std::size_t k : {2 * i, 2 * i + 1})
                for (float& x : splats.axes[k]) x *= kSmall;
    });
    splats.legend.title = "sheets of cracks, a colour each";
    return true;
}

void place(Splats& splats, const PointSet& points, bool discs) {
    const auto& position = points.get<Vec3f>("P");
    splats.centre.resize(points.count);
    splats.axes.resize(discs ? 2 * points.count : 0);
    splats.colour.assign(points.count, 0xffcccccc);
    if (discs) {
        const auto &t1 = points.get<Vec3f>("t1"), &t2 = points.get<Vec3f>("t2");
        parallel_for(points.count, [&](std::size_t i) {
            const float radius = std::max(t1[i].norm(), t2[i].norm());
            splats.centre[i] = {position[i].x(), position[i].y(), position[i].z(), radius};
            splats.axes[2 * i] = {t1[i].x(), t1[i].y(), t1[i].z(), 0};
            splats.axes[2 * i + 1] = {t2[i].x(), t2[i].y(), t2[i].z(), 0};
        });
    } else {
        const auto& radius = points.get<float>("pscale");
        parallel_for(points.count, [&](std::size_t i) {
            splats.centre[i] = {position[i].x(), position[i].y(), position[i].z(), radius[i]};
        });
    }
    double largest = 0, sum = 0;
    for (const auto& c : splats.centre) {
        const Vec3d x(c[0], c[1], c[2]);
        if (!x.allFinite() || !std::isfinite(c[3])) continue;
        splats.bounds.add(x);
        largest = std::max<double>(largest, c[3]);
        sum += c[3];
    }
    splats.typical_radius = sum / static_cast<double>(points.count);
    if (splats.bounds.empty()) return;
    splats.bounds.lower.array() -= largest;
    splats.bounds.upper.array() += largest;
}

}  // namespace

std::string resolve_what(const Frame& frame, const std::string& what, const std::string& attribute) {
    if (what == "particles" || what == "surfels") return what;
    if (what != "auto") throw InputError("preview: --what {}: unknown; say particles, surfels or auto", what);
    if (frame.surfels.count == 0) return "particles";
    if (!attribute.empty() && !has_attribute(frame.surfels, attribute) && has_attribute(frame.particles, attribute))
        return "particles";
    return "surfels";
}

std::vector<double> attribute_values(const PointSet& points, const std::string& attribute) {
    const Attribute* a = points.find(attribute);
    int component = -1;
    if (!a) {
        const auto [name, c] = split_component(attribute);
        a = c >= 0 ? points.find(name) : nullptr;
        if (a && !std::holds_alternative<std::vector<Vec3f>>(a->data)) a = nullptr;
        component = c;
    }
    if (!a) {
        std::string names;
        for (const Attribute& known : points.attributes) names += (names.empty() ? "" : ", ") + known.name;
        throw InputError("preview: --attribute {}: the cache frame has no such attribute; it has {}", attribute,
                         names.empty() ? "none" : names);
    }
    std::vector<double> values(points.count);
    const Vec3d origin = points.origin_of(a->name);
    std::visit(
        [&](const auto& data) {
            parallel_for(points.count, [&](std::size_t i) {
                if constexpr (std::is_same_v<std::decay_t<decltype(data[i])>, Vec3f>)
                    values[i] = component < 0 ? (origin + data[i].template cast<double>()).norm()
                                              : origin[component] + static_cast<double>(data[i][component]);
                else
                    values[i] = static_cast<double>(data[i]);
            });
        },
        a->data);
    return values;
}

ValueRange attribute_range(const PointSet& points, const std::string& attribute) {
    ValueRange range;
    for (const double value : attribute_values(points, attribute))
        if (std::isfinite(value)) range.add(value);
    return range;
}

Splats make_splats(const Frame& frame, const scene::Look& look, const std::string& what, const std::string& attribute,
                   const std::optional<ValueRange>& range) {
    Splats splats;
    const std::string kind = resolve_what(frame, what, attribute);
    const PointSet& points = points_of(frame, kind);
    if (points.count == 0) return splats;
    place(splats, points, kind == "surfels");
    const bool own = attribute.empty() || attribute == "Cd" || attribute == "sheet";
    if (own) colour_by_material(splats, frame, points, look);
    if (colour_by_cracks(splats, points, attribute)) return splats;
    if (colour_by_vectors(splats, points, own ? "Cd" : attribute)) return splats;
    if (!attribute.empty()) colour_by_value(splats, points, attribute, range);
    return splats;
}

}  // namespace thixo::preview
