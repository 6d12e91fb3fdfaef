// What a world allocates in Jolt's memory and has to give back: JavaScript frees none of it.
export class Memory {
  constructor(jolt) {
    Object.assign(this, { jolt, owned: [], references: [] });
  }

  /** An object that Jolt copies where it is used; destroyed by drop(). */
  own(object) {
    this.owned.push(object);
    return object;
  }
  vector([x, y, z]) {
    return this.own(new this.jolt.Vec3(x, y, z));
  }
  point([x, y, z]) {
    return this.own(new this.jolt.RVec3(x, y, z));
  }
  quaternion([w, x, y, z]) {
    return this.own(new this.jolt.Quat(x, y, z, w));
  }

  /** An object that counts its references; one is kept until free(). */
  counted(object) {
    object.AddRef();
    this.references.push(object);
    return object;
  }

  drop() {
    for (const object of this.owned.splice(0)) this.jolt.destroy(object);
  }
  free() {
    this.drop();
    for (const object of this.references.splice(0).reverse()) object.Release();
  }
}
