// Writes the CDR of one sensor_msgs/msg/BatteryState by Fast-CDR, as rmw_fastrtps does, in both byte
// orders and in hexadecimal: FAST_CDR of ros2_bag_test.py. Not part of the build:
//     g++ ros2_bag_cdr.cpp -lfastcdr    (libfastcdr-dev of Debian 12, version 1.0.26)
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

using eprosima::fastcdr::Cdr;

int main() {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  for (const auto order : {Cdr::LITTLE_ENDIANNESS, Cdr::BIG_ENDIANNESS}) {
    char room[512];
    std::memset(room, 0xee, sizeof room);  // Fast-CDR leaves gaps between fields as they are
    eprosima::fastcdr::FastBuffer buffer(room, sizeof room);
    Cdr cdr(buffer, order, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    cdr << std::int32_t{1700000000} << std::uint32_t{250000000} << std::string("battery");
    for (const float value : {12.275f, 21.5f, -20.1f, kUnknown, kUnknown, 50.0f, 0.8f})
      cdr << value;
    cdr << std::uint8_t{2} << std::uint8_t{1} << std::uint8_t{0} << true;
    cdr << std::vector<float>{2.05f, 2.04f} << std::vector<float>{};
    cdr << std::string("left") << std::string("A1");
    for (std::size_t k = 0; k < cdr.getSerializedDataLength(); ++k)
      std::printf("%02x", static_cast<unsigned char>(room[k]));
    std::printf("\n");
  }
}
