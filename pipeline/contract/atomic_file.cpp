#include "pipeline/contract/atomic_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include "pipeline/base/error.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kPrefix = ".thixo-";
constexpr std::string_view kSuffix = ".tmp";
constexpr auto kAbandoned = std::chrono::hours(1);  // of a temporary that another host may own

/// An open file that closes itself.
class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    int get() const { return fd_; }
    int close() { return ::close(std::exchange(fd_, -1)); }

  private:
    int fd_;
};

/// Unlinks the temporary unless it has been renamed.
struct Temporary {
    fs::path path;
    bool kept = false;
    ~Temporary() {
        if (!kept) ::unlink(path.c_str());
    }
};

[[noreturn]] void fail(const fs::path& path, int error) {
    throw ResourceError("cannot write '{}': {}; free space or choose another folder with --out", path.string(),
                        std::strerror(error));
}

struct Fault {
    std::size_t bytes = 0;
    bool kill = false;
};

/// The fault that a test asked for, where it is meant for this call of write_whole.
std::optional<Fault> injected_fault() {
    const char* text = std::getenv("THIXO_WRITE_FAULT");
    if (!text) return std::nullopt;
    static std::atomic<int> calls{0};
    const int call = ++calls;
    int nth = 0;
    unsigned long long bytes = 0;
    std::array<char, 8> how{};
    if (std::sscanf(text, "%d:%llu:%7s", &nth, &bytes, how.data()) != 3)
        throw InputError("THIXO_WRITE_FAULT='{}' is not nth:bytes:how", text);
    if (call < nth) return std::nullopt;
    return Fault{static_cast<std::size_t>(bytes), std::string_view(how.data()) == "kill"};
}

/// 0 or the error number.
int write_all(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), std::size_t(1) << 30));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return n < 0 ? errno : EIO;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return 0;
}

int write_with_fault(int fd, std::string_view bytes, const std::optional<Fault>& fault) {
    if (!fault) return write_all(fd, bytes);
    if (const int error = write_all(fd, bytes.substr(0, fault->bytes))) return error;
    if (fault->kill) ::raise(SIGKILL);
    return ENOSPC;
}

std::string host_name() {
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0) return "host";
    return name.data();
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

void refuse_link(const fs::path& path) {
    std::error_code missing;
    if (fs::is_symlink(path, missing))
        throw InputError("'{}' is a link, and output goes through none; remove it or choose another folder with --out",
                         path.string());
}

/// When a file or folder was last changed. A folder counts as changed when the newest file in it was.
fs::file_time_type last_change(const fs::directory_entry& entry) {
    std::error_code error;
    fs::file_time_type newest = entry.last_write_time(error);
    if (entry.is_symlink(error) || !entry.is_directory(error)) return newest;
    for (fs::directory_iterator it(entry.path(), error), end; !error && it != end; it.increment(error))
        newest = std::max(newest, it->last_write_time(error));
    return newest;
}

/// Seconds that a process has run, by the fields of its line in /proc after its name; none where they do not tell.
std::optional<double> seconds_run(const std::string& fields) {
    constexpr int kStart = 20;  // of the fields from the state on: when it began, in ticks since the system did
    std::istringstream words(fields);
    std::string word;
    for (int k = 0; k < kStart; ++k)
        if (!(words >> word)) return std::nullopt;
    timespec now{};
    const long ticks = ::sysconf(_SC_CLK_TCK);
    if (ticks <= 0 || ::clock_gettime(CLOCK_BOOTTIME, &now) != 0) return std::nullopt;
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) -
           std::strtod(word.c_str(), nullptr) / static_cast<double>(ticks);
}

/// Whether the process that made a file of this age [s] runs. A zombie does not: it has ended, and only its exit code has
/// not been asked for. Numbers are used again: a process that is younger than the file is another one.
bool is_running(pid_t pid, double age) {
    constexpr double kTick = 0.1;
    if (::kill(pid, 0) != 0 && errno == ESRCH) return false;
    std::ifstream file(fmt::format("/proc/{}/stat", pid));
    std::string line;
    if (!std::getline(file, line)) return true;  // no such file system: the number is all that is known
    const std::size_t name = line.rfind(')');
    if (name == line.npos || name + 2 >= line.size()) return true;
    if (line[name + 2] == 'Z') return false;
    const std::optional<double> run = seconds_run(line.substr(name + 2));
    return !run || *run > age - kTick;
}

/// Whether the process that made this temporary is gone. It is where its number on this host is free or now ours. Else
/// only time tells: the temporary has not changed for long.
bool abandoned(const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    pid_t pid = 0;
    const char* first = name.data() + kPrefix.size();
    const auto [end, bad] = std::from_chars(first, name.data() + name.size(), pid);
    if (bad != std::errc() || pid <= 0) return false;
    const std::string host = fmt::format("-{}-", host_name());
    const bool here =
        std::string_view(end, static_cast<std::size_t>(name.data() + name.size() - end)).starts_with(host);
    const auto age = fs::file_time_type::clock::now() - last_change(entry);
    if (here && (pid == ::getpid() || !is_running(pid, std::chrono::duration<double>(age).count()))) return true;
    return age > kAbandoned;
}

[[noreturn]] void cannot_read(const fs::path& path, int error) {
    if (error == ENOENT || error == ENOTDIR) throw CacheError("'{}' is missing", path.string());
    if (error == ELOOP) throw CacheError("'{}' is a link; copy the file itself to its place", path.string());
    throw CacheError("cannot read '{}': {}", path.string(), std::strerror(error));
}

/// All bytes of an open file. `path` is named in messages.
std::string read_open(const Descriptor& file, const fs::path& path, std::uint64_t most = UINT64_MAX) {
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) cannot_read(path, errno);
    if (!S_ISREG(status.st_mode)) throw CacheError("'{}' is not a regular file", path.string());
    const auto there = static_cast<std::uint64_t>(status.st_size);
    if (there > most)
        throw CacheError("'{}' is damaged: it has {} bytes where at most {} can be", path.string(), there, most);
    std::string bytes(static_cast<std::size_t>(there), '\0');
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t n = ::read(file.get(), bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) cannot_read(path, errno);
        if (n == 0) break;
        done += static_cast<std::size_t>(n);
    }
    bytes.resize(done);
    return bytes;
}

}  // namespace

void write_whole(const fs::path& path, std::string_view bytes) {
    const std::optional<Fault> fault = injected_fault();
    const fs::path folder = folder_of(path);
    refuse_link(path);
    Temporary temporary{temporary_path(folder, path.filename().string())};
    Descriptor file(::open(temporary.path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666));
    if (file.get() < 0) fail(path, errno);
    if (const int error = write_with_fault(file.get(), bytes, fault)) fail(path, error);
    if (::fsync(file.get()) != 0) fail(path, errno);
    if (file.close() != 0) fail(path, errno);
    if (::rename(temporary.path.c_str(), path.c_str()) != 0) fail(path, errno);
    temporary.kept = true;
    // The rename itself must survive a power cut before a later file may refer to this one.
    const Descriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (directory.get() < 0 || ::fsync(directory.get()) != 0) fail(path, errno);
}

bool append_line(const fs::path& path, std::string_view line) {
    const Descriptor file(
        ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666));
    struct stat status {};
    if (file.get() < 0 || ::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
    return write_all(file.get(), fmt::format("{}\n", line)) == 0;
}

std::string read_whole(const fs::path& path) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // a pipe must not block
    if (file.get() < 0) cannot_read(path, errno);
    return read_open(file, path);
}

std::string read_inside(const fs::path& folder, const std::string& name, std::uint64_t most) {
    const fs::path path = folder / name;
    Descriptor at(::open(folder.empty() ? "." : folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    const fs::path relative(name);
    for (auto part = relative.begin(); at.get() >= 0 && part != relative.end(); ++part) {
        THIXO_ASSERT(*part != ".." && *part != "/", "the name '{}' leads out of its folder", name);
        const bool last = std::next(part) == relative.end();
        const int kind = last ? O_RDONLY | O_NONBLOCK : O_PATH | O_DIRECTORY;
        Descriptor next(::openat(at.get(), part->c_str(), kind | O_NOFOLLOW | O_CLOEXEC));
        std::swap(at, next);
    }
    if (at.get() < 0) cannot_read(path, errno);
    return read_open(at, path, most);
}

bool starts_with(const fs::path& path, std::string_view start) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
    std::string found(start.size(), '\0');
    return file.get() >= 0 && ::read(file.get(), found.data(), found.size()) == static_cast<ssize_t>(start.size()) &&
           found == start;
}

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw ResourceError("cannot make folder '{}': {}; choose another with --out", folder.string(), error.message());
}

fs::path make_subfolder(const fs::path& folder, const fs::path& name) {
    make_folder(folder);
    fs::path path = folder;
    for (const fs::path& part : name) {
        path /= part;
        refuse_link(path);
        std::error_code error;
        fs::create_directory(path, error);
        if (error == std::errc::file_exists || error == std::errc::not_a_directory)
            throw InputError("'{}' is no folder; remove it or choose another folder with --out", path.string());
        if (error)
            throw ResourceError("cannot make folder '{}': {}; choose another with --out", path.string(),
                                error.message());
    }
    return path;
}

fs::path temporary_path(const fs::path& folder, std::string_view name) {
    return folder / fmt::format("{}{}-{}-{}{}", kPrefix, ::getpid(), host_name(), name, kSuffix);
}

int remove_stale_temporaries(const fs::path& folder) {
    std::error_code error;
    int removed = 0;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix) || !abandoned(*it)) continue;
        std::error_code ignored;
        if (fs::remove_all(it->path(), ignored) > 0) ++removed;
    }
    return removed;
}

}  // namespace thixo
