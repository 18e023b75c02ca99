#pragma once

#include <boost/interprocess/mapped_region.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace battery_sof {

/// A topic of a bag, as one publisher wrote it.
struct BagConnection {
  std::uint32_t id = 0;
  std::string topic, type, md5sum;
};

/**
 * @brief A bag of format 2.0, opened for reading: https://wiki.ros.org/Bags/Format/2.0.
 *
 * Every length and every index entry is checked before anything is read by it. A compressed chunk
 * may claim to hold up to a thousand times its bytes, or 4 MiB; a chunk may be listed once. The file
 * is mapped rather than read: bags with pictures in them are larger than memory.
 */
class BagReader {
 public:
  /// What becomes of a message: its record time [ns] and its bytes, which are valid meanwhile.
  using Take = std::function<void(std::uint64_t time, std::string_view message)>;

  /**
   * @brief Walks the records from the first byte to the last.
   * @throws RecordingError naming the file, the byte and what is wrong there; for a bag of another
   * format, one that is encrypted, and one without an index too.
   */
  explicit BagReader(const std::filesystem::path& path);

  /// Those that have a message, in the order of the index.
  const std::vector<BagConnection>& connections() const { return connections_; }

  /**
   * @brief Reads the messages of a connection in the order of the file, one chunk in memory at a
   * time. A record time of 0 is none: such a message is passed over, as by rosbag.
   * @throws std::runtime_error when a chunk that holds one cannot be read.
   */
  void read(const BagConnection& connection, const Take& take) const;

 private:
  /// Where messages of one connection begin in a chunk, and when they were recorded.
  struct IndexEntry {
    std::uint64_t time = 0;    ///< [ns]
    std::uint32_t offset = 0;  ///< in the chunk's bytes as they were before compression
  };
  struct Index {
    std::uint32_t connection = 0;
    std::vector<IndexEntry> entries;
  };
  struct Chunk {
    std::string_view compression, bytes;
    std::size_t size = 0;  ///< of the bytes before compression
    bool is_listed = false;
    std::vector<Index> indices;
  };
  class Walk;

  boost::interprocess::mapped_region file_;
  std::vector<Chunk> chunks_;
  std::vector<BagConnection> connections_;
};

}  // namespace battery_sof
