! Equation (16) under the load m = (b sin(omega tau))^2, one drive period on [0, 1].
! U = (stretch, stretch rate, phase s of the load); PAR(1:6) = omega, theta, S, b, c, eta.
! Boundary conditions of periodic type with s(0) = 0: IPS = 7 gives the multipliers and
! every solution starts at load phase 0, where m = 0. PAR(9) is the stretch there.

      SUBROUTINE FUNC(NDIM,U,ICP,PAR,IJAC,F,DFDU,DFDP)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM,NDIM), DFDP(NDIM,*)
      DOUBLE PRECISION, PARAMETER :: PI = 3.14159265358979323846D0
      DOUBLE PRECISION X,V,X2,X4,X7,M,T,R,N,SN,DM,C
      X = U(1)
      V = U(2)
      T = PI/PAR(1)
      C = PAR(5)
      SN = SIN(PI*U(3))
      M = (PAR(4)*SN)**2
      X2 = X*X
      X4 = X2*X2
      X7 = X4*X2*X
      R = 1/(X7 + 2*C*X)
      N = 6*C*V*V - 3*(PAR(2)*(X4*X4 - X2) - PAR(3)*X7 + M*X4 + PAR(6)*V*X7)
      F(1) = T*V
      F(2) = T*N*R
      F(3) = 1
      IF(IJAC==0)RETURN
      DM = 2*PI*PAR(4)**2*SN*COS(PI*U(3))
      DFDU(1,1) = 0
      DFDU(1,2) = T
      DFDU(1,3) = 0
      DFDU(2,1) = T*R*(-3*(PAR(2)*(8*X7 - 2*X) - 7*PAR(3)*X4*X2 + 4*M*X2*X &
                + 7*PAR(6)*V*X4*X2) - N*R*(7*X4*X2 + 2*C))
      DFDU(2,2) = T*R*(12*C*V - 3*PAR(6)*X7)
      DFDU(2,3) = -3*T*R*X4*DM
      DFDU(3,1) = 0
      DFDU(3,2) = 0
      DFDU(3,3) = 0
      IF(IJAC==1)RETURN
      DFDP(1,1) = -F(1)/PAR(1)
      DFDP(2,1) = -F(2)/PAR(1)
      DFDP(3,1) = 0
      DFDP(1,2:6) = 0
      DFDP(3,2:6) = 0
      DFDP(2,2) = -3*T*R*(X4*X4 - X2)
      DFDP(2,3) = 3*T*R*X7
      DFDP(2,4) = -6*T*R*PAR(4)*SN*SN*X4
      DFDP(2,5) = T*R*(6*V*V - 2*N*R*X)
      DFDP(2,6) = -3*T*R*V*X7
      END SUBROUTINE FUNC

      SUBROUTINE STPNT(NDIM,U,PAR,T)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM),PAR(*)
      DOUBLE PRECISION, INTENT(IN) :: T
      OPEN(UNIT=31,FILE='start.par',STATUS='OLD')
      READ(31,*) PAR(1:6)
      CLOSE(31)
      END SUBROUTINE STPNT

      SUBROUTINE BCND(NDIM,PAR,ICP,NBC,U0,U1,FB,IJAC,DBC)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), NBC, IJAC
      DOUBLE PRECISION, INTENT(IN) :: PAR(*), U0(NDIM), U1(NDIM)
      DOUBLE PRECISION, INTENT(OUT) :: FB(NBC)
      DOUBLE PRECISION, INTENT(INOUT) :: DBC(NBC,*)
      FB(1) = U0(1) - U1(1)
      FB(2) = U0(2) - U1(2)
      FB(3) = U0(3)
      IF(IJAC==0)RETURN
      DBC(1:3,1:2*NDIM) = 0
      DBC(1,1) = 1
      DBC(1,4) = -1
      DBC(2,2) = 1
      DBC(2,5) = -1
      DBC(3,3) = 1
      IF(IJAC==1)RETURN
      DBC(1:3,2*NDIM+1:2*NDIM+6) = 0
      END SUBROUTINE BCND

      SUBROUTINE ICND
      END SUBROUTINE ICND

      SUBROUTINE FOPT
      END SUBROUTINE FOPT

      SUBROUTINE PVLS(NDIM,U,PAR)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: PAR(*)
      DOUBLE PRECISION, EXTERNAL :: GETP
      PAR(9) = GETP("BV0",1,U)
      END SUBROUTINE PVLS
