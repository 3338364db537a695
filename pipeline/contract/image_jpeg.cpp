// JPEG, by libjpeg. Its errors leave it by longjmp: what runs inside of it holds no objects.
#include <csetjmp>
#include <cstdio>
// This header needs that one.
#include <jpeglib.h>

#include "pipeline/base/error.h"
#include "pipeline/contract/image.h"

namespace thixo {
namespace {

constexpr double kLargestJpegShrink = 1100;  // bytes of memory that a byte of a file may ask for
constexpr int kMostScans = 500;              // of a progressive one, each of which goes over all pixels

/// What libjpeg holds; nothing before it is made.
struct JpegMemory : jpeg_decompress_struct {
    JpegMemory() : jpeg_decompress_struct{} {}
    ~JpegMemory() { jpeg_destroy_decompress(this); }
    JpegMemory(const JpegMemory&) = delete;
    JpegMemory& operator=(const JpegMemory&) = delete;
};

class Jpeg {
  public:
    Jpeg(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {
        decompress_.err = jpeg_std_error(&errors_);
        errors_.error_exit = [](j_common_ptr common) { fail(common); };
        // What libjpeg would go on with is damaged all the same: a file that ends early, for example.
        errors_.emit_message = [](j_common_ptr common, int level) {
            if (level < 0) fail(common);
        };
        decompress_.client_data = this;
        run([](Jpeg& j) { jpeg_create_decompress(&j.decompress_); });
        progress_.progress_monitor = [](j_common_ptr common) { limit_scans(common); };
        decompress_.progress = &progress_;
        run([](Jpeg& j) {
            jpeg_mem_src(&j.decompress_, reinterpret_cast<const unsigned char*>(j.bytes_.data()), j.bytes_.size());
            jpeg_read_header(&j.decompress_, TRUE);
        });
    }
    double pixels() const { return double(decompress_.image_width) * double(decompress_.image_height); }

    Image8 image() {
        if (decompress_.num_components != 1 && decompress_.num_components != 3)
            throw CacheError("'{}' has {} components; export it as RGB", file_, decompress_.num_components);
        if (3 * pixels() / kLargestJpegShrink > double(bytes_.size()))
            throw CacheError("'{}' is damaged: it is too short for its size in pixels", file_);
        Image8 image{static_cast<int>(decompress_.image_width), static_cast<int>(decompress_.image_height), 3, {}};
        image.values.resize(3 * static_cast<std::size_t>(pixels()));
        rows_ = image.values.data();
        run([](Jpeg& j) { j.read_rows(); });
        return image;
    }

  private:
    void read_rows() {
        decompress_.out_color_space = JCS_RGB;
        decompress_.dct_method = JDCT_ISLOW;
        jpeg_start_decompress(&decompress_);
        while (decompress_.output_scanline < decompress_.output_height) {
            JSAMPROW row = rows_ + std::size_t(3) * decompress_.output_width * decompress_.output_scanline;
            jpeg_read_scanlines(&decompress_, &row, 1);
        }
        jpeg_finish_decompress(&decompress_);
    }

    void run(void (*step)(Jpeg&)) {
        if (setjmp(back_) == 0)
            step(*this);
        else
            damaged();
    }
    [[noreturn]] void damaged() {
        const std::string why = message_;
        throw CacheError("'{}' is damaged or not a JPEG: {}", file_, why);
    }
    [[noreturn]] static void fail(j_common_ptr common) {
        Jpeg& self = *static_cast<Jpeg*>(common->client_data);
        common->err->format_message(common, self.message_);
        std::longjmp(self.back_, 1);
    }
    static void limit_scans(j_common_ptr common) {
        Jpeg& self = *static_cast<Jpeg*>(common->client_data);
        if (self.decompress_.input_scan_number <= kMostScans) return;
        std::snprintf(self.message_, sizeof self.message_, "it has more than %d scans", kMostScans);
        std::longjmp(self.back_, 1);
    }

    std::string_view bytes_;
    const std::string& file_;
    JpegMemory decompress_;
    jpeg_error_mgr errors_{};
    jpeg_progress_mgr progress_{};
    std::jmp_buf back_{};
    char message_[JMSG_LENGTH_MAX] = {};
    JSAMPLE* rows_ = nullptr;
};

}  // namespace

Image8 decode_jpeg(std::string_view bytes, const std::string& file) { return Jpeg(bytes, file).image(); }

double jpeg_pixels(std::string_view bytes, const std::string& file) { return Jpeg(bytes, file).pixels(); }

}  // namespace thixo
