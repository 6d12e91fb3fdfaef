// Joints in the worlds of engines: their coordinates from the poses of their bodies. No engine here takes joints yet.

export const startOfJoints = () => [];
export const followJoints = () => {};
export const jointRows = () => [];
export const jointWrenches = () => {};
export const namesOfJointForces = () => "";
