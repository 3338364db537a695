// Makes OpenVDB read the values of nodes of point grids only as far as there is room for them. The templates of its
// grids call what is specialised here.
#pragma once

#include <openvdb/Exceptions.h>
#include <openvdb/Types.h>
#include <openvdb/io/Compression.h>

#include <array>
#include <cstring>
#include <istream>

namespace thixo {

/// A chunk of values begins with its length: above 0 of bytes by Blosc, whose header tells both lengths, else minus
/// that of plain bytes. OpenVDB reads the latter before it compares them with `bytes`, the room there is, and trusts the
/// header. Throws openvdb::IoError where a length is another; leaves the stream where it was.
inline void check_chunk(std::istream& in, std::size_t bytes) {
    constexpr std::size_t kHeader = 16;  // flags of 4 bytes, length of the values, of a block, of the chunk
    const auto begin = in.tellg();
    std::int64_t length = 0;
    in.read(reinterpret_cast<char*>(&length), sizeof length);
    bool right = false;
    if (length > 0) {
        std::array<char, kHeader> header{};
        in.read(header.data(), kHeader);
        std::uint32_t values = 0, chunk = 0;
        std::memcpy(&values, header.data() + 4, sizeof values);
        std::memcpy(&chunk, header.data() + 12, sizeof chunk);
        right = values == bytes && static_cast<std::int64_t>(chunk) == length && chunk <= bytes + kHeader;
    } else {
        right = length == -static_cast<std::int64_t>(bytes);
    }
    if (!right) throw openvdb::IoError("the values of a node have another length");
    in.seekg(begin);
}

}  // namespace thixo

namespace openvdb::OPENVDB_VERSION_NAME::io {

template <>
inline void readData<PointDataIndex32>(std::istream& in, PointDataIndex32* data, Index count, uint32_t compression,
                                       DelayedLoadMetadata*, size_t) {
    const std::size_t bytes = sizeof(PointDataIndex32) * count;
    if (data == nullptr || !(compression & COMPRESS_BLOSC) || (compression & COMPRESS_ZIP))
        throw IoError("the values of a node are stored in another way");
    thixo::check_chunk(in, bytes);
    bloscFromStream(in, reinterpret_cast<char*>(data), bytes);
}

}  // namespace openvdb::OPENVDB_VERSION_NAME::io
