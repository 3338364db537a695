#include "sim/checkpoint.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "THIXOCKP";
constexpr std::size_t kHashLength = 32;
constexpr int kKept = 2;

class Writer {
  public:
    template <class T>
    void value(const char*, const T& v) {
        bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
    }
    void text(const char* name, const std::string& t) {
        value(name, static_cast<std::uint64_t>(t.size()));
        bytes_ += t;
    }
    template <class T>
    void array(const char* name, const std::vector<T>& a) {
        text(name, name);
        value(name, static_cast<std::uint32_t>(sizeof(T)));
        value(name, static_cast<std::uint64_t>(a.size()));
        bytes_.append(reinterpret_cast<const char*>(a.data()), a.size() * sizeof(T));
    }
    std::string& bytes() { return bytes_; }

  private:
    std::string bytes_;
};

class Reader {
  public:
    Reader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}
    template <class T>
    void value(const char* name, T& v) {
        std::memcpy(static_cast<void*>(&v), take(name, sizeof v), sizeof v);
    }
    void text(const char* name, std::string& t) {
        std::uint64_t length = 0;
        value(name, length);
        t.assign(take(name, length), length);
    }
    template <class T>
    void array(const char* name, std::vector<T>& a) {
        std::string stored;
        text(name, stored);
        std::uint32_t size = 0;
        std::uint64_t count = 0;
        value(name, size);
        value(name, count);
        if (stored != name || size != sizeof(T) || count > bytes_.size() / sizeof(T))
            throw CacheError("{}: holds '{}' where '{}' is expected", file_, stored, name);
        a.resize(count);
        std::memcpy(static_cast<void*>(a.data()), take(name, count * sizeof(T)), count * sizeof(T));
    }
    bool at_end() const { return bytes_.empty(); }

  private:
    const char* take(const char* name, std::uint64_t length) {
        if (length > bytes_.size()) throw CacheError("{}: ends within '{}'", file_, name);
        const char* at = bytes_.data();
        bytes_.remove_prefix(length);
        return at;
    }
    std::string_view bytes_;
    const std::string& file_;
};

template <class Stream, class S>
void visit_solids(Stream& stream, S& s) {
    for (auto& body : s.bodies) {
        stream.value("solid.turn", body.turn);
        stream.value("solid.place", body.place);
    }
    for (auto& grip : s.grips) stream.array("solid.anchor", grip.anchor);
    stream.value("solid.last_dt", s.last_dt);
    stream.value("solid.stretch2", s.stretch2);
    for_each_array(s.elements, [&](const char* name, auto& array) { stream.array(name, array); });
    for_each_array(s.contacts.nodes, [&](const char* name, auto& array) { stream.array(name, array); });
    if (s.phases.any) {
        stream.array("solid.bond", s.phases.bond);
        stream.array("solid.refrozen", s.phases.refrozen);
        stream.array("solid.rest", s.elements.rest);
        stream.array("solid.depth", s.elements.depth);
        if constexpr (!std::is_const_v<S>) find_refrozen_neighbours(s);
        // Rates are those found with the bonds of that time.
        stream.array("solid.laws", s.laws);
        stream.array("solid.rates", s.rates);
        stream.array("solid.flow", s.phases.flow.plastic);
    }
}

/// One list of what a checkpoint holds, for writing (S const) and reading.
template <class Stream, class S>
void visit_state(Stream& stream, S& s) {
    stream.value("frame", s.clock.frame);
    stream.value("step", s.clock.step);
    stream.value("time", s.clock.time);
    stream.value("last_dt", s.clock.last_dt);
    stream.value("next_id", s.next_id);
    for (auto& e : s.emitters) {
        stream.value("layer", e.layer);
        stream.value("next", e.next);
        stream.value("due", e.due);
        stream.value("blocked", e.blocked);
        stream.value("pushing", e.pushing);
    }
    for_each_array(s.particles, [&](const char* name, auto& array) { stream.array(name, array); });
    if constexpr (!std::is_const_v<S>) adopt_particles(s.problem.scene, s.problem.smoothing, s.particles, s.solids);
    if (!s.solids.empty()) visit_solids(stream, s.solids);
    if (!s.solids.empty()) {
        stream.array("mixed.taken", s.mixed_surface.taken);
        stream.value("mixed.next_id", s.mixed_surface.animated.next_id);
        stream.array("mixed.lift", s.mixed_surface.animated.lift);
        stream.value("mixed.unmeasured", s.mixed_surface.animated.unmeasured);
        for_each_array(s.mixed_surface.animated, [&](const char* name, auto& array) { stream.array(name, array); });
        for_each_array(s.mixed_surface.zombies, [&](const char* name, auto& array) { stream.array(name, array); });
        for_each_array(s.mixed_surface.refrozen, [&](const char* name, auto& array) { stream.array(name, array); });
    }
    stream.value("surface.next_id", s.surface.next_id);
    stream.array("surface.lift", s.surface.lift);
    stream.value("surface.unmeasured", s.surface.unmeasured);
    for_each_array(s.surface, [&](const char* name, auto& array) { stream.array(name, array); });
}

fs::path folder_of(const fs::path& out) { return out / "checkpoint"; }
fs::path file_of(const fs::path& out, int frame) { return folder_of(out) / fmt::format("checkpoint.{:04}.bin", frame); }

}  // namespace

std::string print_checkpoint(const Simulation& s, const std::string& simulation_hash) {
    Writer w;
    w.bytes() = kMagic;
    w.value("format", kCheckpointFormat);
    w.value("precision", static_cast<std::uint32_t>(sizeof(Real)));
    w.text("hash", simulation_hash);
    w.value("emitters", static_cast<std::uint64_t>(s.emitters.size()));
    visit_state(w, s);
    w.bytes() += hash_hex(w.bytes());
    return std::move(w.bytes());
}

void parse_checkpoint(std::string_view bytes, const std::string& file, const std::string& simulation_hash,
                      Simulation& s) {
    if (bytes.size() < kMagic.size() + kHashLength || bytes.substr(0, kMagic.size()) != kMagic)
        throw CacheError("{}: is not a checkpoint", file);
    const std::string_view body = bytes.substr(0, bytes.size() - kHashLength);
    if (hash_hex(body) != bytes.substr(body.size())) throw CacheError("{}: is damaged, its checksum differs", file);
    Reader r(body.substr(kMagic.size()), file);
    std::uint32_t format = 0, precision = 0;
    std::uint64_t emitters = 0;
    std::string hash;
    r.value("format", format);
    if (format != kCheckpointFormat)
        throw CacheError("{}: has format {}, this program reads {}", file, format, kCheckpointFormat);
    r.value("precision", precision);
    if (precision != sizeof(Real)) throw CacheError("{}: was written in another precision", file);
    r.text("hash", hash);
    if (hash != simulation_hash) throw CacheError("{}: belongs to another scene", file);
    r.value("emitters", emitters);
    if (emitters != s.emitters.size())
        throw CacheError("{}: has {} emitters, the scene has {}", file, emitters, s.emitters.size());
    visit_state(r, s);
    if (!r.at_end()) throw CacheError("{}: is longer than its content", file);
    move_walls(s.walls, s.clock.time);
}

std::vector<int> list_checkpoints(const fs::path& out) {
    std::vector<int> frames;
    std::error_code missing;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_of(out), missing)) {
        const std::string name = entry.path().filename().string();
        constexpr std::string_view head = "checkpoint.", tail = ".bin";
        if (!name.starts_with(head) || !name.ends_with(tail) || name.size() <= head.size() + tail.size()) continue;
        const char *first = name.data() + head.size(), *last = name.data() + name.size() - tail.size();
        int frame = 0;
        if (const auto [end, error] = std::from_chars(first, last, frame); error == std::errc() && end == last)
            frames.push_back(frame);
    }
    std::sort(frames.begin(), frames.end(), std::greater<>());
    return frames;
}

void write_checkpoint(const fs::path& out, int frame, std::string_view bytes) {
    make_folder(folder_of(out));
    write_whole(file_of(out, frame), bytes);
    const std::vector<int> frames = list_checkpoints(out);
    for (std::size_t k = kKept; k < frames.size(); ++k) {
        std::error_code ignored;  // an old checkpoint that stays does no harm
        fs::remove(file_of(out, frames[k]), ignored);
    }
}

bool restore_checkpoint(const fs::path& out, int last, const std::string& simulation_hash, Simulation& s) {
    remove_stale_temporaries(folder_of(out));
    for (const int frame : list_checkpoints(out)) {
        if (frame > last) continue;
        const fs::path file = file_of(out, frame);
        const std::size_t untouched = s.particles.size();
        try {
            parse_checkpoint(read_whole(file), file.string(), simulation_hash, s);
            return true;
        } catch (const CacheError& e) {
            // All that can be wrong is found before the state is touched, but for a file made to deceive the checksum.
            THIXO_ASSERT(s.clock.step == 0 && s.particles.size() == untouched, "{} was read in part", file.string());
            log_warning("{}; going on from an earlier state", e.what());
        }
    }
    return false;
}

void remove_checkpoints(const fs::path& out) {
    for (const int frame : list_checkpoints(out)) {
        std::error_code ignored;  // another scene's checkpoint is refused by its hash
        fs::remove(file_of(out, frame), ignored);
    }
}

}  // namespace thixo
