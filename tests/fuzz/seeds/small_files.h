// Minimal valid files that use every feature of their format.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::tests {

inline constexpr std::string_view kSmallBvh = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftUpLeg
  {
    OFFSET 10 -5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -40 0
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -10 -5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -40 0
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.0083333
0 90 0 0 0 0 1 2 3 4 5 6
1 90 0 0 0 5 1 2 3 4 5 6
2 90 0 0 0 9 1 2 3 4 5 6
)";

inline constexpr std::string_view kSmallAsf = R"(:version 1.10
:name small
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
  none
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lhipjoint
     direction 0.6 -0.7 0.2
     length 2.4
     axis 0 0 0  XYZ
  end
  begin
     id 2
     name lfemur
     direction 0.3 -0.9 0
     length 7
     axis 0 0 20  XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 3
     name rhipjoint
     direction -0.6 -0.7 0.2
     length 2.4
     axis 0 0 0  XYZ
  end
  begin
     id 4
     name rfemur
     direction -0.3 -0.9 0
     length 7
     axis 0 0 -20  XYZ
    dof rx ry rz l
  end
:hierarchy
  begin
    root lhipjoint rhipjoint
    lhipjoint lfemur
    rhipjoint rfemur
  end
)";

inline constexpr std::string_view kSmallAmc = R"(#!OML:ASF small.asf
:FULLY-SPECIFIED
:DEGREES
1
root 9.3 17.8 -17.3 -2.0 -2.5 -3.8
lfemur 5 6 7
rfemur 1 2 3 0.1
2
root 9.4 17.8 -17.3 -2.0 -2.5 -3.8
lfemur 5 6 7
rfemur 1 2 3 0.1
3
root 9.5 17.8 -17.3 -2.0 -2.5 -3.8
lfemur 5 6 8
rfemur 1 2 4 0.1
)";

inline std::string SmallAmcWithAsf() {
  return std::string(kSmallAsf) + '\0' + std::string(kSmallAmc);
}

inline constexpr std::string_view kSmallTrc =
    "PathFileType\t4\t(X/Y/Z)\tsmall.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
    "OrigNumFrames\n"
    "100\t100\t3\t3\tmm\t100\t1\t3\n"
    "Frame#\tTime\tLASI\t\t\tRASI\t\t\tHEAD\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\n"
    "\n"
    "1\t0.00\t100\t900\t0\t-100\t900\t0\t0\t1700\t0\n"
    "2\t0.01\t101\t900\t0\t-99\t900\t0\t\t\t\n"
    "3\t0.02\t102\t900\t0\t-98\t900\t0\t2\t1700\t0\n";

inline constexpr std::string_view kSmallUrdf = R"(<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/>
  <link name="tip">
    <visual><origin xyz="0 0 1"/><geometry><box size="1 2 3"/></geometry></visual>
    <visual><geometry><cylinder radius="1" length="2"/></geometry></visual>
    <visual><geometry><sphere radius="1"/></geometry></visual>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1" rpy="0 0.1 0"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/><child link="lower"/><axis xyz="1 0 0"/>
    <mimic joint="shoulder" multiplier="-2" offset="0.5"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="lower"/><child link="tip"/><limit lower="0" upper="0.2"/>
  </joint>
</robot>
)";

inline constexpr std::string_view kSmallMarkerSet = R"(motiondb-marker-set 1
name small
marker LHip   # left
marker RHip
marker "the knee"
hips LHip RHip
"the knee" = 0.5 LHip + 0.5 RHip
mapping one
signature pelvis l_thigh
LHip = l_thigh
RHip = 0.9 r_thigh + 0.1 pelvis
"the knee" = 1 l_thigh offset l_thigh 0 -0.02 0
)";

}  // namespace motiondb::tests
