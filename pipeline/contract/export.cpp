#include "pipeline/contract/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little,
              "exported files are written as the machine holds its numbers");

template <class T>
void put(std::string& out, T value) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    out.append(raw.data(), raw.size());
}

template <class V>
using Element = typename std::decay_t<V>::value_type;
template <class T>
constexpr bool kIsVector = std::is_same_v<T, Vec3f> || std::is_same_v<T, Vec3d>;

/// f(value of row i) for an attribute. Places far from the world's origin are doubles.
template <class F>
void with_value(const PointSet& points, const Attribute& a, std::size_t i, F&& f) {
    std::visit(
        [&](const auto& v) {
            if constexpr (kIsVector<Element<decltype(v)>>)
                if (const Vec3d origin = points.origin_of(a.name); !origin.isZero()) {
                    f(Vec3d(origin + v[i].template cast<double>()));
                    return;
                }
            f(v[i]);
        },
        a.data);
}

/// Rows in ascending id, so that a particle's row is found by tools that know no ids; in their own order where there
/// are none.
std::vector<std::size_t> row_order(const PointSet& points) {
    std::vector<std::size_t> order(points.count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    const Attribute* id = points.find("id");
    if (!id) return order;
    std::visit(
        [&](const auto& v) {
            if constexpr (!kIsVector<Element<decltype(v)>>)
                std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return v[a] < v[b]; });
        },
        id->data);
    return order;
}

// ---- csv
// --------------------------------------------------------------------------------------------------------------------------

void append_cell(std::string& out, float v) { fmt::format_to(std::back_inserter(out), "{}", v); }
void append_cell(std::string& out, std::int32_t v) { fmt::format_to(std::back_inserter(out), "{}", v); }
void append_cell(std::string& out, std::int64_t v) { fmt::format_to(std::back_inserter(out), "{}", v); }
template <class T>
void append_cell(std::string& out, const Eigen::Matrix<T, 3, 1>& v) {
    fmt::format_to(std::back_inserter(out), "{},{},{}", v.x(), v.y(), v.z());
}

std::string csv(const PointSet& points, const std::vector<std::size_t>& order) {
    std::string out;
    for (const Attribute& a : points.attributes) {
        if (!out.empty()) out += ',';
        if (std::holds_alternative<std::vector<Vec3f>>(a.data))
            out += fmt::format("{0}.x,{0}.y,{0}.z", a.name);
        else
            out += a.name;
    }
    out += '\n';
    for (const std::size_t i : order) {
        for (std::size_t c = 0; c < points.attributes.size(); ++c) {
            if (c > 0) out += ',';
            with_value(points, points.attributes[c], i, [&](const auto& v) { append_cell(out, v); });
        }
        out += '\n';
    }
    return out;
}

// ---- ply
// --------------------------------------------------------------------------------------------------------------------------

/// The properties of an attribute, by the names other programs look for.
std::string ply_properties(const PointSet& points, const Attribute& a) {
    const char* real = points.origin_of(a.name).isZero() ? "float" : "double";
    if (a.name == "P") return fmt::format("property {0} x\nproperty {0} y\nproperty {0} z\n", real);
    if (a.name == "N") return "property float nx\nproperty float ny\nproperty float nz\n";
    if (a.name == "pscale") return "property float radius\n";
    if (std::holds_alternative<std::vector<Vec3f>>(a.data))
        return fmt::format("property {1} {0}_x\nproperty {1} {0}_y\nproperty {1} {0}_z\n", a.name, real);
    if (std::holds_alternative<std::vector<float>>(a.data)) return fmt::format("property float {}\n", a.name);
    if (std::holds_alternative<std::vector<std::int32_t>>(a.data)) return fmt::format("property int {}\n", a.name);
    return fmt::format("property double {}\n", a.name);
}

void put_property(std::string& out, float v) { put(out, v); }
void put_property(std::string& out, std::int32_t v) { put(out, v); }
void put_property(std::string& out, std::int64_t v) { put(out, static_cast<double>(v)); }  // PLY has no 64-bit integers
template <class T>
void put_property(std::string& out, const Eigen::Matrix<T, 3, 1>& v) {
    for (int c = 0; c < 3; ++c) put(out, v[c]);
}

std::string ply(const PointSet& points, const std::vector<std::size_t>& order) {
    std::vector<const Attribute*> columns;
    for (const char* name : {"P", "N", "pscale"})
        if (const Attribute* a = points.find(name)) columns.push_back(a);
    for (const Attribute& a : points.attributes)
        if (a.name != "P" && a.name != "N" && a.name != "pscale") columns.push_back(&a);
    std::string out =
        fmt::format("ply\nformat binary_little_endian 1.0\ncomment Thixo\nelement vertex {}\n", points.count);
    for (const Attribute* a : columns) out += ply_properties(points, *a);
    out += "end_header\n";
    for (const std::size_t i : order)
        for (const Attribute* a : columns) with_value(points, *a, i, [&](const auto& v) { put_property(out, v); });
    return out;
}

// ---- vtp
// --------------------------------------------------------------------------------------------------------------------------

template <class T>
constexpr const char* kVtkType = "Float32";
template <>
constexpr const char* kVtkType<Vec3d> = "Float64";
template <>
constexpr const char* kVtkType<std::int32_t> = "Int32";
template <>
constexpr const char* kVtkType<std::int64_t> = "Int64";

/// The appended part: each array is its length in bytes (64 bits), then its values.
class Appended {
  public:
    /// `value(i)` for i in [0, n), and the element that refers to them.
    template <class T, class F>
    std::string array(const std::string& name, std::size_t n, F&& value) {
        const std::string element = fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
            kVtkType<T>, name, kIsVector<T> ? 3 : 1, bytes_.size());
        put(bytes_, static_cast<std::uint64_t>(n * sizeof(T)));
        for (std::size_t i = 0; i < n; ++i) {
            if constexpr (kIsVector<T>)
                put_property(bytes_, value(i));
            else
                put(bytes_, static_cast<T>(value(i)));
        }
        return element;
    }
    const std::string& bytes() const { return bytes_; }

  private:
    std::string bytes_;
};

/// An attribute in ascending id.
std::string vtp_array(const PointSet& points, const Attribute& a, const std::string& name,
                      const std::vector<std::size_t>& order, Appended& appended) {
    std::string element;
    const Vec3d origin = points.origin_of(a.name);
    std::visit(
        [&](const auto& v) {
            using T = Element<decltype(v)>;
            if constexpr (kIsVector<T>)
                if (!origin.isZero()) {
                    element = appended.array<Vec3d>(name, order.size(), [&](std::size_t i) {
                        return Vec3d(origin + v[order[i]].template cast<double>());
                    });
                    return;
                }
            element = appended.array<T>(name, order.size(), [&](std::size_t i) { return v[order[i]]; });
        },
        a.data);
    return element;
}

std::string vtp(const PointSet& points, const std::vector<std::size_t>& order) {
    const std::size_t n = points.count;
    const Attribute none{"P", std::vector<Vec3f>()};
    const Attribute* places = points.find("P");
    Appended appended;
    std::string out =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<PolyData>\n";
    out += fmt::format(
        "<Piece NumberOfPoints=\"{0}\" NumberOfVerts=\"{0}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
        "NumberOfPolys=\"0\">\n<PointData>\n",
        n);
    for (const Attribute& a : points.attributes)
        if (a.name != "P") out += vtp_array(points, a, a.name, order, appended);
    out += "</PointData>\n<Points>\n" + vtp_array(points, places ? *places : none, "Points", order, appended);
    out += "</Points>\n<Verts>\n" + appended.array<std::int64_t>("connectivity", n, [](std::size_t i) { return i; });
    out += appended.array<std::int64_t>("offsets", n, [](std::size_t i) { return i + 1; });
    out += "</Verts>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    return out + appended.bytes() + "\n</AppendedData>\n</VTKFile>\n";
}

struct TimedFile {
    double time;
    std::string name;
};

std::string pvd(const std::vector<TimedFile>& files) {
    std::string out =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
        "byte_order=\"LittleEndian\">\n<Collection>\n";
    for (const TimedFile& f : files)
        out += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", f.time, f.name);
    return out + "</Collection>\n</VTKFile>\n";
}

constexpr std::array<const char*, 3> kFormats{"ply", "vtp", "csv"};
constexpr std::array<const char*, 2> kWhats{"particles", "surfels"};

}  // namespace

ExportFormat parse_export_format(std::string_view text) {
    for (std::size_t i = 0; i < kFormats.size(); ++i)
        if (text == kFormats[i]) return static_cast<ExportFormat>(i);
    throw InputError("export format '{}' is not known; use ply, vtp or csv", text);
}

ExportWhat parse_export_what(std::string_view text) {
    for (std::size_t i = 0; i < kWhats.size(); ++i)
        if (text == kWhats[i]) return static_cast<ExportWhat>(i);
    throw InputError("cannot export '{}'; use particles or surfels", text);
}

std::string export_points(const PointSet& points, ExportFormat format) {
    const std::vector<std::size_t> order = row_order(points);
    if (format == ExportFormat::csv) return csv(points, order);
    return format == ExportFormat::ply ? ply(points, order) : vtp(points, order);
}

std::vector<fs::path> export_cache(const CacheReader& reader, const std::vector<int>& frames, ExportFormat format,
                                   ExportWhat what, const fs::path& out_dir) {
    const char* kind = kWhats[static_cast<std::size_t>(what)];
    make_folder(out_dir);
    remove_stale_temporaries(out_dir);
    std::vector<fs::path> written;
    std::vector<TimedFile> timed;
    for (const int number : frames) {
        const PointSet points =
            what == ExportWhat::particles ? reader.load_particles(number) : reader.load_surfels(number);
        const std::string name = fmt::format("{}.{:04}.{}", kind, number, kFormats[static_cast<std::size_t>(format)]);
        write_whole(out_dir / name, export_points(points, format));
        written.push_back(out_dir / name);
        timed.push_back({reader.manifest().find(number)->time, name});
    }
    if (format == ExportFormat::vtp) {
        written.push_back(out_dir / fmt::format("{}.pvd", kind));
        write_whole(written.back(), pvd(timed));
    }
    return written;
}

}  // namespace thixo
