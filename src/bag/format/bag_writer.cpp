#include "bag/format/bag_writer.hpp"

#include <cstdint>
#include <fstream>
#include <map>
#include <stdexcept>

namespace battery_sof {

namespace {

constexpr std::size_t kChunkThreshold = std::size_t{768} * 1024;  // [bytes], rosbag's
constexpr std::size_t kHeaderRecordSize = 4096;  // [bytes], likewise: its data fill it
constexpr std::uint32_t kTopicNumber = 0;        // the only one
constexpr std::uint32_t kFormatVersion = 1;      // of indices, and of the list of chunks

template <typename Value>
std::string bytesOf(Value value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string bytesOf(const Stamp& stamp) { return bytesOf(stamp.sec) + bytesOf(stamp.nsec); }

std::string sized(const std::string& bytes) {
  return bytesOf(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

/// The fields of a header, in the order of their names.
std::string headerOf(const std::map<std::string, std::string>& fields) {
  std::string header;
  for (const auto& [name, value] : fields) header += sized(name + "=" + value);
  return header;
}

std::string recordOf(char operation, std::map<std::string, std::string> fields,
                     const std::string& data) {
  fields["op"] = operation;
  return sized(headerOf(fields)) + sized(data);
}

std::string connectionOf(const std::string& topic) {
  return recordOf('\x07', {{"conn", bytesOf(kTopicNumber)}, {"topic", topic}},
                  headerOf({{"md5sum", BatteryStateMessage::kMd5},
                            {"message_definition", BatteryStateMessage::definition()},
                            {"type", BatteryStateMessage::kType}}));
}

class BagWriter {
 public:
  BagWriter(const std::filesystem::path& path, const std::string& topic)
      : file_(path, std::ios::binary | std::ios::trunc), connection_(connectionOf(topic)) {
    write("#ROSBAG V2.0\n" + header(0));
    chunk_ = connection_;
  }

  void add(const Stamp& time, const std::string& message) {
    if (count_ == 0) begin_ = time;
    end_ = time;
    index_ += bytesOf(time) + bytesOf(static_cast<std::uint32_t>(chunk_.size()));
    chunk_ += recordOf('\x02', {{"conn", bytesOf(kTopicNumber)}, {"time", bytesOf(time)}}, message);
    ++count_;
    if (chunk_.size() > kChunkThreshold) endChunk();
  }

  void close() {
    if (count_ > 0) endChunk();
    const std::uint64_t index_at = written_;
    if (chunks_ > 0) write(connection_ + infos_);
    file_.seekp(13);  // behind the line of the version
    write(header(index_at));
    file_.close();
    if (!file_) throw std::runtime_error("no permission or no space");
  }

 private:
  std::string header(std::uint64_t index_at) const {
    const std::string fields = headerOf({{"chunk_count", bytesOf(chunks_)},
                                         {"conn_count", bytesOf(chunks_ > 0 ? 1u : 0u)},
                                         {"index_pos", bytesOf(index_at)},
                                         {"op", "\x03"}});
    return sized(fields) + sized(std::string(kHeaderRecordSize - fields.size(), ' '));
  }

  void endChunk() {
    const auto size = static_cast<std::uint32_t>(chunk_.size());
    infos_ += recordOf('\x06',
                       {{"chunk_pos", bytesOf(written_)},
                        {"count", bytesOf(1u)},
                        {"end_time", bytesOf(end_)},
                        {"start_time", bytesOf(begin_)},
                        {"ver", bytesOf(kFormatVersion)}},
                       bytesOf(kTopicNumber) + bytesOf(count_));
    write(recordOf('\x05', {{"compression", "none"}, {"size", bytesOf(size)}}, chunk_));
    write(recordOf('\x04',
                   {{"conn", bytesOf(kTopicNumber)},
                    {"count", bytesOf(count_)},
                    {"ver", bytesOf(kFormatVersion)}},
                   index_));
    ++chunks_;
    count_ = 0;
    chunk_.clear();
    index_.clear();
  }

  void write(const std::string& bytes) {
    file_ << bytes;
    written_ += bytes.size();
    if (!file_) throw std::runtime_error("no permission or no space");
  }

  std::ofstream file_;
  std::string connection_, infos_;
  std::uint64_t written_ = 0;
  std::uint32_t chunks_ = 0;
  // of the chunk that is being filled
  std::string chunk_, index_;
  Stamp begin_, end_;
  std::uint32_t count_ = 0;
};

}  // namespace

void writeBatteryStates(const std::filesystem::path& path, const std::string& topic,
                        const std::vector<BatteryStateMessage>& messages) {
  BagWriter bag(path, topic);
  for (const BatteryStateMessage& message : messages) {
    const bool is_zero = message.stamp.sec == 0 && message.stamp.nsec == 0;
    bag.add(is_zero ? Stamp{0, 1} : message.stamp, message.serialized());
  }
  bag.close();
}

}  // namespace battery_sof
