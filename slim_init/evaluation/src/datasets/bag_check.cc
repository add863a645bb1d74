// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/bag_check.h"

#include <rosbag/stream.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace slim_init::evaluation {
namespace {

constexpr char kMagic[] = "#ROSBAG V2.0\n";
constexpr std::uint64_t kMagicLength = sizeof(kMagic) - 1;
// Values of the field "op".
constexpr int kMessage = 2, kFileHeader = 3, kIndex = 4, kChunk = 5, kChunkInfo = 6,
              kConnection = 7;
// Chunks hold 768 kB, or one message that is larger.
constexpr std::uint64_t kMaxChunk = std::uint64_t{1} << 30;
// Headers hold a topic, a type and its definition.
constexpr std::uint64_t kMaxHeader = std::uint64_t{1} << 24;
// Time and offset of an entry of the index; connection and count of an entry of a chunk's record.
constexpr std::uint64_t kIndexEntry = 12, kChunkInfoEntry = 8;

struct Damage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <typename... Parts>
[[noreturn]] void fail(std::uint64_t at, const Parts&... parts) {
  std::ostringstream what;
  what << "byte " << at << ": ";
  (what << ... << parts);
  throw Damage(what.str());
}

std::uint32_t number32(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// Fields "name=value", each with its length in front.
class Header {
 public:
  Header(const std::string& bytes, std::uint64_t at) : at_(at) {
    std::uint64_t i = 0;
    while (i < bytes.size()) {
      if (bytes.size() - i < 4) fail(at, "a header ends within a length");
      const std::uint64_t length = number32(&bytes[i]);
      i += 4;
      if (length > bytes.size() - i) {
        fail(at, "a field of ", length, " bytes, ", bytes.size() - i, " are left of its header");
      }
      const std::string field = bytes.substr(i, length);
      i += length;
      const std::size_t equals = field.find('=');
      if (equals == std::string::npos) fail(at, "a field without a name");
      fields_[field.substr(0, equals)] = field.substr(equals + 1);
    }
  }

  // -1: a record without one.
  int op() const {
    const auto field = fields_.find("op");
    return field == fields_.end() || field->second.size() != 1
               ? -1
               : static_cast<unsigned char>(field->second[0]);
  }
  std::string text(const std::string& name) const {
    const auto field = fields_.find(name);
    if (field == fields_.end()) fail(at_, "no field \"", name, "\"");
    return field->second;
  }
  std::uint64_t number(const std::string& name, std::size_t bytes) const {
    const std::string value = text(name);
    if (value.size() != bytes) {
      fail(at_, "field \"", name, "\" has ", value.size(), " bytes, must have ", bytes);
    }
    const std::uint64_t low = number32(value.data());
    return bytes == 8 ? low | std::uint64_t{number32(value.data() + 4)} << 32 : low;
  }

 private:
  std::uint64_t at_;
  std::map<std::string, std::string> fields_;
};

// The bytes of the chunk that the index records after it point into: unpacked, or in the file.
struct Chunk {
  std::uint64_t at = 0;  // of its data in the file
  std::uint64_t size = 0;
  bool packed = false;
  std::vector<std::uint8_t> unpacked;
};

class BagCheck {
 public:
  explicit BagCheck(const std::string& path) : file_(path, std::ios::binary) {
    file_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(file_.tellg(), 0));
  }

  void run() {
    if (read(0, kMagicLength) != kMagic) fail(0, "not a bag of format 2.0");
    for (std::uint64_t at = kMagicLength; at < size_;) at = record(at);
    for (const auto& [at, position] : claimed_chunks_) {
      const auto chunk = records_.find(position);
      if (chunk == records_.end() || chunk->second != kChunk) {
        fail(at, "no chunk at byte ", position);
      }
    }
    for (const auto& [connection, at] : indexed_connections_) {
      if (known_connections_.count(connection) == 0) {
        fail(at, "an index of connection ", connection, ", which is not listed");
      }
    }
    followSummary();
  }

 private:
  std::string read(std::uint64_t at, std::uint64_t count) {
    if (at > size_ || count > size_ - at) {
      fail(at, count, " bytes are wanted, the file ends after ", size_ - std::min(at, size_));
    }
    std::string bytes(count, '\0');
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(&bytes[0], static_cast<std::streamsize>(count));
    if (!file_) fail(at, "cannot be read");
    return bytes;
  }

  std::uint32_t read32(std::uint64_t at) { return number32(read(at, 4).data()); }

  // Returns where the next one begins.
  std::uint64_t record(std::uint64_t at) {
    const std::uint64_t header_length = read32(at);
    if (header_length > kMaxHeader) {
      fail(at, "a header of ", header_length, " bytes");
    }
    const Header header(read(at + 4, header_length), at);
    const std::uint64_t data = at + 4 + header_length + 4;
    const std::uint64_t length = read32(data - 4);
    if (length > size_ - data) {
      fail(at, "a record of ", length, " bytes, the file ends after ", size_ - data);
    }
    records_[at] = header.op();
    switch (header.op()) {
      case kFileHeader:
        if (at != kMagicLength) fail(at, "a second file header");
        summary_at_ = header.number("index_pos", 8);
        connections_ = header.number("conn_count", 4);
        chunk_infos_ = header.number("chunk_count", 4);
        break;
      case kChunk: readChunk(header, at, data, length); break;
      case kIndex: followIndex(header, at, data, length); break;
      case kChunkInfo:
        claimed_chunks_[at] = header.number("chunk_pos", 8);
        entries(header, at, length, kChunkInfoEntry);
        break;
      case kConnection:
        if (length > kMaxHeader) fail(at, "a connection of ", length);
        Header(read(data, length), data);
        known_connections_.insert(header.number("conn", 4));
        break;
      default: break;
    }
    return data + length;
  }

  // The connections, then the chunks, one after the other from the byte that the file header names.
  // The library reads them there, whatever there is.
  void followSummary() {
    // What a recorder that was killed leaves; the library says so.
    if (summary_at_ == 0) return;
    auto next = records_.find(summary_at_);
    for (std::uint64_t i = 0; i < connections_ + chunk_infos_; ++i) {
      const bool connection = i < connections_;
      if (next == records_.end() || next->second != (connection ? kConnection : kChunkInfo)) {
        fail(kMagicLength, connections_, " connections and ", chunk_infos_, " chunks from byte ",
             summary_at_, " on: number ", i, " is not there");
      }
      ++next;
    }
  }

  // Number of entries of a record, which they have to fill.
  static std::uint64_t entries(const Header& header, std::uint64_t at, std::uint64_t length,
                               std::uint64_t size) {
    const std::uint64_t count = header.number("count", 4);
    if (count * size != length) {
      fail(at, count, " entries of ", size, " bytes in a record of ", length);
    }
    return count;
  }

  void readChunk(const Header& header, std::uint64_t at, std::uint64_t data, std::uint64_t length) {
    chunk_ = Chunk();
    chunk_.at = data;
    chunk_.size = header.number("size", 4);
    if (chunk_.size > kMaxChunk) {
      fail(at, "a chunk of ", chunk_.size, " bytes");
    }
    const std::string compression = header.text("compression");
    if (compression == "none") {
      if (chunk_.size > length) {
        fail(at, "a chunk of ", chunk_.size, " bytes in a record of ", length);
      }
      return;
    }
    chunk_.packed = true;
    std::string packed = read(data, length);
    // One more than nothing: a pointer is wanted.
    chunk_.unpacked.resize(chunk_.size + 1);
    auto* from = reinterpret_cast<std::uint8_t*>(&packed[0]);
    const auto count = static_cast<unsigned int>(length);
    const auto size = static_cast<unsigned int>(chunk_.size);
    if (compression == "bz2") {
      rosbag::BZ2Stream(nullptr).decompress(chunk_.unpacked.data(), size, from, count);
    } else if (compression == "lz4") {
      rosbag::LZ4Stream(nullptr).decompress(chunk_.unpacked.data(), size, from, count);
    } else {
      fail(at, "compression is \"", compression, "\", must be none, bz2 or lz4");
    }
  }

  std::string inChunk(std::uint64_t offset, std::uint64_t count) {
    if (!chunk_.packed) return read(chunk_.at + offset, count);
    return std::string(reinterpret_cast<const char*>(&chunk_.unpacked[offset]), count);
  }

  // Length of what begins at an offset of the chunk with its length.
  std::uint64_t lengthInChunk(std::uint64_t at, std::uint64_t offset) {
    if (offset + 4 <= chunk_.size) {
      const std::uint64_t length = number32(inChunk(offset, 4).data());
      if (length <= chunk_.size - offset - 4) return length;
    }
    fail(at, "an entry of the index points behind the end of its chunk of ", chunk_.size, " bytes");
  }

  // The message at an offset of the chunk: its header, then its data. Whatever else stood there the
  // library would take the data of for another header.
  void followEntry(std::uint64_t at, std::uint64_t offset) {
    const std::uint64_t length = lengthInChunk(at, offset);
    if (length > kMaxHeader) {
      fail(at, "a message with a header of ", length, " bytes");
    }
    const int op = Header(inChunk(offset + 4, length), at).op();
    if (op != kMessage) {
      fail(at, "an entry of the index points at a record of kind ", op, ", not at a message");
    }
    lengthInChunk(at, offset + 4 + length);
  }

  void followIndex(const Header& header, std::uint64_t at, std::uint64_t data,
                   std::uint64_t length) {
    if (chunk_.at == 0) fail(at, "an index without a chunk before it");
    const std::uint64_t count = entries(header, at, length, kIndexEntry);
    indexed_connections_[header.number("conn", 4)] = at;
    const std::string offsets = read(data, length);
    for (std::uint64_t i = 0; i < count; ++i) {
      followEntry(at, number32(&offsets[i * kIndexEntry + 8]));
    }
  }

  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::map<std::uint64_t, int> records_;                   // what there is at which byte
  std::map<std::uint64_t, std::uint64_t> claimed_chunks_;  // by the record that says so
  std::set<std::uint64_t> known_connections_;
  std::map<std::uint64_t, std::uint64_t> indexed_connections_;  // by connection: such an index
  // Of the file header: where connections and chunks are listed, and how many.
  std::uint64_t summary_at_ = 0, connections_ = 0, chunk_infos_ = 0;
  Chunk chunk_;  // the last one
};

}  // namespace

std::string bagDamage(const std::string& path) {
  try {
    BagCheck(path).run();
  } catch (const Damage& damage) {
    return damage.what();
  }
  return std::string();
}

}  // namespace slim_init::evaluation
